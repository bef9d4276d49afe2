// What segcal_t stands for inside.
#pragma once

#include "api/convert.h"

#if defined(__FAST_MATH__)
#error \
    "segcal must not be compiled with -ffast-math: it reorders sums, drops checks for NaN, and no replay has its bits"
#elif defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error "segcal must not be compiled with -ffinite-math-only: it drops checks for NaN"
#endif

namespace SEGCAL_NS {

extern template class Device<Real>;  // device.cpp

/// What both blocks begin with. Bytes of a library with another layout
/// are no device, and two blocks are one only if they were made together.
struct MemoryHead {
  static constexpr std::uint32_t kHotBytes = sizeof(Device<Real>), kColdBytes = sizeof(ColdParts<Real>),
                                 kHot = 0x5E6CA102u ^ kHotBytes ^ (kColdBytes << 8), kCold = ~kHot;
  std::uint32_t magic;
  std::uint32_t pair;
};
struct ColdBlock {
  MemoryHead head;
  ColdParts<Real> parts;
};
/// The hot block. The cold one is in the same memory behind it, or in one of its own.
struct CDevice {
  MemoryHead head;
  Device<Real> device;
};

/// The device behind a handle; null if the handle is null or was never created.
inline CDevice* open(segcal_t* handle) {
  CDevice* d = reinterpret_cast<CDevice*>(handle);
  return d && d->head.magic == MemoryHead::kHot ? d : nullptr;
}
inline const CDevice* open(const segcal_t* handle) { return open(const_cast<segcal_t*>(handle)); }

/// The kept segment in a slot; null if there is none.
inline const Segment<Real>* find_slot(const CDevice& d, std::int32_t index) {
  if (index < 0 || index > SEGCAL_MAX_SEGMENTS || !d.device.database().kept(index)) return nullptr;
  return &d.device.database().slot(index);
}

/// What calls that read a kept segment's states begin with: its checks, and the segment if all is well.
inline int open_slot(const segcal_t* handle, std::int32_t index, const void* out, std::int32_t capacity,
                     const CDevice** d, const Segment<Real>** segment) {
  if (!out) return SEGCAL_ERROR_NULL;
  if (capacity < 0) return SEGCAL_ERROR_SIZE;
  *d = open(handle);
  *segment = *d ? find_slot(**d, index) : nullptr;
  if (!*segment) return SEGCAL_ERROR_STATE;
  return (*d)->device.segments_at_rest() ? SEGCAL_OK : SEGCAL_ERROR_BUSY;
}

inline std::int64_t keyframe_time(const Segment<Real>& s, int k) { return s.t0_ns + std::int64_t(s.t_us[k]) * 1000; }

}  // namespace SEGCAL_NS
