// What segcal_t stands for inside.
#pragma once

#include "api/convert.h"

namespace SEGCAL_NS {

struct CDevice {
  static constexpr std::uint32_t kMagic = 0x5E6CA101u;
  std::uint32_t magic;
  TrackPoint<Real> points[kMaxFramePoints];  ///< incoming points on their way through
  Device<Real> device;
};

/// The device behind a handle; null if the handle is null or was never created.
inline CDevice* open(segcal_t* handle) {
  CDevice* d = reinterpret_cast<CDevice*>(handle);
  return d && d->magic == CDevice::kMagic ? d : nullptr;
}
inline const CDevice* open(const segcal_t* handle) { return open(const_cast<segcal_t*>(handle)); }

}  // namespace SEGCAL_NS
