// A device's state to and from flash, for one profile (Core::restore, Core::save).
#pragma once

#include "segcal/segcal.h"
#include "state/flash_image.h"

namespace host {
namespace SEGCAL_NS {

void restore_device(segcal_t* device, FlashImage* flash);
void save_device(segcal_t* device, FlashImage* flash);

}  // namespace SEGCAL_NS
}  // namespace host
