// The C API of the store: checks, and which work is under way.
#include <new>

#include "store/device_records.h"

namespace SEGCAL_NS {
namespace {

struct Store {
  static constexpr std::uint32_t kMagic = 0x5E6CA102u;
  std::uint32_t magic;
  bool restoring;
  Ring ring;
  DeviceRecords records;
};
static_assert(sizeof(Store) <= sizeof(segcal_store_t), "SEGCAL_STORE_WORDS is too small");
static_assert(alignof(Store) <= alignof(segcal_store_t), "segcal_store_t is not aligned enough");

Store* opened(segcal_store_t* store) {
  Store* s = reinterpret_cast<Store*>(store);
  return s && s->magic == Store::kMagic ? s : nullptr;
}
const Store* opened(const segcal_store_t* store) { return opened(const_cast<segcal_store_t*>(store)); }

/// What save and restore begin with: nothing else is under way, and a device.
int check_both(const Store* s, const CDevice* d) {
  if (!s || !d) return SEGCAL_ERROR_STATE;
  if (s->ring.busy()) return SEGCAL_ERROR_BUSY;
  return d->device.options().joint_filter ? SEGCAL_ERROR_CONFIG : SEGCAL_OK;
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" {

int segcal_store_open(segcal_store_t* store, const segcal_flash_t* flash) {
  if (!store || !flash) return SEGCAL_ERROR_NULL;
  store->memory[0] = 0;
  if (!Flash::valid(*flash)) return SEGCAL_ERROR_SIZE;
  Store* s = new (store) Store{};
  s->ring.open(*flash);
  s->magic = Store::kMagic;
  return SEGCAL_OK;
}

int segcal_store_work(segcal_store_t* store, int32_t pieces) {
  Store* s = opened(store);
  if (!s || !s->ring.busy()) return SEGCAL_ERROR_STATE;
  if (pieces < 0) return SEGCAL_ERROR_SIZE;
  bool done = false;
  for (; pieces > 0 && !done; --pieces) done = s->ring.step();
  if (!done) return 1;
  const int answer = s->ring.answer();
  if (s->restoring && answer != SEGCAL_OK) s->records.leave_empty();
  s->records.detach();
  s->restoring = false;
  return answer;
}

int segcal_save(segcal_store_t* store, segcal_t* device) {
  Store* s = opened(store);
  CDevice* d = open(device);
  const int error = check_both(s, d);
  if (error != SEGCAL_OK) return error;
  if (!s->ring.known()) return s->ring.answer() < 0 ? s->ring.answer() : SEGCAL_ERROR_STATE;
  if (!DeviceRecords::Stored::at_rest(d->device)) return SEGCAL_ERROR_BUSY;
  s->records.attach(d);
  s->ring.save(s->records.source());
  return SEGCAL_OK;
}

int segcal_restore(segcal_store_t* store, segcal_t* device) {
  Store* s = opened(store);
  CDevice* d = open(device);
  const int error = check_both(s, d);
  if (error != SEGCAL_OK) return error;
  if (!DeviceRecords::Stored::untouched(d->device)) return SEGCAL_ERROR_STATE;
  s->records.attach(d);
  s->restoring = true;
  const RecordSink sink = s->records.sink();
  s->ring.look(&sink);
  return SEGCAL_OK;
}

const char* segcal_store_difference(const segcal_store_t* store) {
  const Store* s = opened(store);
  return s && s->records.difference() ? s->records.difference() : "";
}

int segcal_store_get_info(const segcal_store_t* store, segcal_store_info_t* info) {
  if (!info) return SEGCAL_ERROR_NULL;
  const Store* s = opened(store);
  if (!s) return SEGCAL_ERROR_STATE;
  s->ring.fill(info);
  return SEGCAL_OK;
}

uint32_t segcal_store_blocks(const segcal_flash_t* flash) {
  if (!flash || !Flash::valid(*flash)) return 0;
  Flash f;
  f.begin(*flash);
  // A state at its largest: every slot's and epoch's fields are fewer
  // than its bytes in memory; and the same again for the next one.
  const std::uint32_t page = f.page_bytes(), rest = sizeof(CalibrationReport<Real>) + sizeof(DeviceOptions<Real>) +
                                                    sizeof(StoredNumbers<Real>);
  const std::uint32_t epochs =
      kEpochs > 0 ? kEpochs * (sizeof(Epoch<Real>) + 32 + page) + sizeof(Changes<Real>) + 32 + page : 0;
  const std::uint32_t sessions = kHistory > 0 ? kHistory * (sizeof(HistoryEntry<Real>) + 32 + page) + 32 + page : 0;
  const std::uint32_t bytes =
      SEGCAL_MAX_SEGMENTS * (sizeof(Segment<Real>) + 32 + page) + epochs + sessions + rest + 4 * page;
  const std::uint32_t of_block = flash->erase_bytes - page;
  return 2 * ((bytes + of_block - 1) / of_block);
}

}  // extern "C"
