// Clocks that are far apart: odometry does not run with them, so that there is no fit to ask. Rotation tells the offset
// beforehand (clock/clock_search.h); what is left of it is an effect like others.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "diagnose/budget.h"
#include "diagnose/diagnose.h"
#include "diagnose/told.h"

namespace host::diagnosis {

using RunAligned = std::function<Diagnosis(const std::vector<Recording>& aligned, const Told& told, Budget& budget)>;

/// `run` with the stamps of all cameras moved by the camera chain's timeshift_cam_imu, and again, where odometry is
/// lost with them, by what rotation shows. Offsets in the answer count from the recording's own stamps. An offset that
/// rotation found is named also where nothing of it was left to be found: what it closes of the gap is not known then,
/// since nothing can be fitted without it. Again as well, with the work that is left and at least what one effect
/// needs, where the first look found no name: that answer counts if it has one; and where it could judge nothing. A
/// rolling shutter that rotation shows is in the model from then on.
Diagnosis with_clocks_aligned(const std::vector<Recording>& sessions, const CoreOptions& options,
                              const RunAligned& run);

}  // namespace host::diagnosis
