// Before a calibration is believed: was the data used, is the step plausible, do segments agree, is an effect missing?
#pragma once

#include "replay/replay.h"

namespace host::review {

/// Fills result->health, with notes on what was stated (stated.h), and result->cause. Widens sigmas where segments
/// disagree by more than noise does (segment_scatter.h), and takes `calibrated` back, with everything as it was, where
///  - the odometry used less than half of the images that it was offered,
///  - the fit leaves more than twice the stated noise,
///  - the step from the start is one that the prior does not allow (chi-square, p < 1e-6),
///  - an effect that the model lacks would move a released value by more than three of its sigmas (missing_effects.h),
///  - more than half of the newer half of the last session's segments, and three at least, do not follow their own IMU
///  samples with what the odometry
///    believed,
///  - the segments disagree with each other by more than five times what noise leaves,
///  - a step of a part of theta, which the kept segments show, puts a released value two sigmas from the answer
///  (calibration_step.h),
///  - fewer than half of the parameters are observed with the widened sigmas,
///  - one segment alone is kept: nothing says whether its residuals are independent,
///  - the newest segments contradict the others, and are too few to decide what is right (calibration/changes.h).
void review(const std::vector<Recording>& sessions, const CoreOptions& options, Core& core, ReplayResult* result);

}  // namespace host::review
