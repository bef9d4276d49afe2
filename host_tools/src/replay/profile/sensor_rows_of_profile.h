// What one kept segment says through each of its sensors (CoreSensorRows).
#pragma once

#include "replay/core.h"
#include "segcal/segcal.h"
#include "segments/elimination.h"

namespace host {
namespace SEGCAL_NS {

namespace core = ::SEGCAL_NS;

/// The candidates as the core has them. Throws InputError where the profile has no room for them beside theta's terms.
core::CandidateTerms terms_of(const std::vector<CoreTerm>& candidates, const core::Calibration<double>& theta);

/// `candidates`: terms that get columns behind theta's.
CoreSensorRows sensor_rows_of(const core::Segment<double>& segment, const core::Calibration<double>& theta,
                              const core::MeasurementModel<double>& model, const std::vector<CoreTerm>& candidates);
/// Of a kept segment at the last calibration.
CoreSensorRows sensor_rows_of(segcal_t* device, int slot, const std::vector<CoreTerm>& candidates);

}  // namespace SEGCAL_NS
}  // namespace host
