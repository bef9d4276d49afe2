// The C API: a device's memory, its beginning, and its going on at another place.
#include <cstddef>
#include <cstring>
#include <new>

#include "api/capacities.h"
#include "api/handle.h"
#include "segcal/blocks.h"

namespace SEGCAL_NS {

using Cold = ColdBlock;

/// Of the cold block in the same memory.
constexpr std::size_t kColdOffset =
    (sizeof(CDevice) + SEGCAL_STORAGE_ALIGNMENT - 1) / SEGCAL_STORAGE_ALIGNMENT * SEGCAL_STORAGE_ALIGNMENT;
constexpr std::size_t kBytes = kColdOffset + sizeof(Cold);

static_assert(sizeof(CDevice) <= SEGCAL_HOT_BYTES && sizeof(Cold) <= SEGCAL_COLD_BYTES &&
                  kBytes <= SEGCAL_STORAGE_BYTES,
              "storage.h has too few bytes for the device");
static_assert(SEGCAL_STORAGE_BYTES < kBytes + kBytes / 16, "SEGCAL_STORAGE_BYTES wastes memory");
static_assert(alignof(CDevice) <= SEGCAL_STORAGE_ALIGNMENT && alignof(Cold) <= SEGCAL_STORAGE_ALIGNMENT,
              "SEGCAL_STORAGE_ALIGNMENT is too small for the device");

namespace {

bool aligned(const void* memory) { return reinterpret_cast<std::uintptr_t>(memory) % SEGCAL_STORAGE_ALIGNMENT == 0; }

Cold* behind(void* hot) { return reinterpret_cast<Cold*>(static_cast<char*>(hot) + kColdOffset); }

bool overlap(const void* hot, const void* cold) {
  const auto h = reinterpret_cast<std::uintptr_t>(hot), c = reinterpret_cast<std::uintptr_t>(cold);
  return h < c + sizeof(Cold) && c < h + sizeof(CDevice);
}

/// Where they are made, and another number than that of a device which was there before.
std::uint32_t pair_number(const void* hot, const void* cold) {
  std::uint32_t before;
  std::memcpy(&before, static_cast<const char*>(hot) + offsetof(MemoryHead, pair), sizeof before);
  return before + 1u +
         static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(hot) * 2654435761u +
                                    reinterpret_cast<std::uintptr_t>(cold));
}

[[gnu::cold]] int create(segcal_t** device, const segcal_config_t& config, void* hot, void* cold, bool fits,
                         const std::uint32_t* capacities) {
  *device = nullptr;
  if (first_difference(capacities) < SEGCAL_N_CAPACITIES) return SEGCAL_ERROR_CAPACITY;
  if (!fits || overlap(hot, cold)) return SEGCAL_ERROR_SIZE;
  if (!aligned(hot) || !aligned(cold)) return SEGCAL_ERROR_ALIGNMENT;
  DeviceOptions<Real> options;
  if (!options_from_config(config, &options)) return SEGCAL_ERROR_CONFIG;
  const std::uint32_t pair = pair_number(hot, cold);
  std::memset(hot, 0, sizeof(CDevice));
  std::memset(cold, 0, sizeof(Cold));
  CDevice* d = new (hot) CDevice;
  Cold* c = new (cold) Cold;
  d->device.create(options, &c->parts);
  d->head = {MemoryHead::kHot, pair};
  c->head = {MemoryHead::kCold, pair};
  *device = reinterpret_cast<segcal_t*>(d);
  return SEGCAL_OK;
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" {

size_t segcal_storage_bytes(void) { return kBytes; }
size_t segcal_hot_bytes(void) { return sizeof(CDevice); }
size_t segcal_cold_bytes(void) { return sizeof(Cold); }

void segcal_memory(size_t* state_bytes, size_t* segment_bytes, size_t* workspace_bytes) {
  if (state_bytes) *state_bytes = kBytes;
  if (segment_bytes) *segment_bytes = sizeof(Segment<Real>);
  if (workspace_bytes) *workspace_bytes = Device<Real>::workspace_bytes();
}

int segcal_create_for(segcal_t** device, const segcal_config_t* config, void* storage, size_t storage_bytes,
                      const uint32_t* capacities) {
  if (!device || !config || !storage || !capacities) return SEGCAL_ERROR_NULL;
  return create(device, *config, storage, behind(storage), storage_bytes >= kBytes, capacities);
}

int segcal_create_in_blocks_for(segcal_t** device, const segcal_config_t* config, void* hot, size_t hot_bytes,
                                void* cold, size_t cold_bytes, const uint32_t* capacities) {
  if (!device || !config || !hot || !cold || !capacities) return SEGCAL_ERROR_NULL;
  return create(device, *config, hot, cold, hot_bytes >= sizeof(CDevice) && cold_bytes >= sizeof(Cold), capacities);
}

[[gnu::cold]] int segcal_attach(segcal_t** device, void* hot, void* cold) {
  if (!device || !hot) return SEGCAL_ERROR_NULL;
  *device = nullptr;
  if (!aligned(hot) || !aligned(cold)) return SEGCAL_ERROR_ALIGNMENT;
  CDevice* d = open(static_cast<segcal_t*>(hot));
  if (!d) return SEGCAL_ERROR_STATE;
  if (!cold && d->device.cold() != &behind(hot)->parts) return SEGCAL_ERROR_NULL;
  Cold* c = cold ? static_cast<Cold*>(cold) : behind(hot);
  if (c->head.magic != MemoryHead::kCold || c->head.pair != d->head.pair) return SEGCAL_ERROR_STATE;
  if (!d->device.attach(&c->parts)) return SEGCAL_ERROR_BUSY;
  *device = static_cast<segcal_t*>(hot);
  return SEGCAL_OK;
}

}  // extern "C"
