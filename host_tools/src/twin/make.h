// The options that simulate a recording's twin.
#pragma once

#include "twin/twin.h"

namespace host::twin {

/// The fit with what was taken into the model.
const ReplayResult& last_fit(const Diagnosis& found);

/// A fit knows no steps: what it found of a device that changed is a mean. Where a step was named, the device becomes
/// what it was before.
void put_before_step(const Diagnosis& found, Calibration* device);

/// With the stated noise and no effect. Throws InputError where there is no motion or no scene to follow.
SimulationOptions plain_twin(const Recording& session, const Diagnosis& found, const DiagnoseOptions& options);

/// The same with the effects that were found, and the noise that samples and tracks show; what these are goes to
/// `said`.
SimulationOptions with_effects(SimulationOptions plain, const Recording& session, const Diagnosis& found,
                               const DiagnoseOptions& options, Comparison* said);

}  // namespace host::twin
