// Did a bias change at once? A driver that trims a sensor anew, a sensor
// that starts again, a shock: the model lets biases walk and no more.
#pragma once

#include <optional>

#include "replay/replay.h"

namespace host::review {

/// The step of one bias between two keyframes that explains most of what a calibration leaves, where chance and the
/// dispersion that was observed do not explain it (docs/diagnosis.md, section 10). Empty too where nothing can be
/// asked: with effects of the IMU in the model, of which the reference's residuals (reference/problem.h) know nothing.
std::optional<Suspect> bias_step(const std::vector<Recording>& sessions, const ReplayResult& result);

}  // namespace host::review
