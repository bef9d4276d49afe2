#include "replay/profile/store_of_profile.h"

#include <string>

#include "recording.h"

namespace host {
namespace SEGCAL_NS {
namespace {

[[noreturn]] void refuse(const segcal_store_t& store, int error) {
  const std::string field = segcal_store_difference(&store);
  segcal_store_info_t info{};
  segcal_store_get_info(&store, &info);
  switch (error) {
    case SEGCAL_ERROR_CONFIG:
      throw InputError("saved with another configuration (" + field +
                       " differs): expected the options, priors and start of the run that wrote it" +
                       (field == "starting calibration" ? "; --calib FILE names its start" : ""));
    case SEGCAL_ERROR_CAPACITY:
      throw InputError("saved with other capacities or by another version of segcal (" + field + ")");
    case SEGCAL_ERROR_VERSION:
      throw InputError("expected format " + std::to_string(SEGCAL_STORE_MAJOR) + " of a stored device, found " +
                       std::to_string(info.format_major) + ", of a newer segcal");
    case SEGCAL_EMPTY: throw InputError("expected the state of a device, found none that is whole");
    case SEGCAL_ERROR_FULL: throw InputError("too small for the device's state");
    default: throw InputError("the device's state cannot be read or stored (error " + std::to_string(error) + ")");
  }
}

/// Does what was begun to its end.
void finish(segcal_store_t* store, int begun, bool may_be_empty) {
  while (begun == SEGCAL_OK || begun == 1) {
    begun = segcal_store_work(store, INT32_MAX);
    if (begun == SEGCAL_OK || (begun == SEGCAL_EMPTY && may_be_empty)) return;
  }
  refuse(*store, begun);
}

}  // namespace

void restore_device(segcal_t* device, FlashImage* flash) {
  const segcal_flash_t port = flash->port();
  segcal_store_t store;
  finish(&store, segcal_store_open(&store, &port), false);
  finish(&store, segcal_restore(&store, device), false);
}

void save_device(segcal_t* device, FlashImage* flash) {
  if (flash->bytes.empty()) {
    flash->make(2);
    const segcal_flash_t geometry = flash->port();
    flash->make(segcal_store_blocks(&geometry));
  }
  const segcal_flash_t port = flash->port();
  segcal_store_t store;
  finish(&store, segcal_store_open(&store, &port), true);
  finish(&store, segcal_save(&store, device), false);
}

}  // namespace SEGCAL_NS
}  // namespace host
