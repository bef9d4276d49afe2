// What one kept segment says through each of its sensors, at the last calibration (CoreSensorRows).
#pragma once

#include "replay/core.h"
#include "segcal/segcal.h"

namespace host {
namespace SEGCAL_NS {

/// `candidates`: terms that get columns behind theta's. Throws InputError where the profile has no room for them.
CoreSensorRows sensor_rows_of(segcal_t* device, int slot, const std::vector<CoreTerm>& candidates);

}  // namespace SEGCAL_NS
}  // namespace host
