// Is the joint filter where its sigmas say?
#pragma once

#include "replay/replay.h"

namespace host::review {

/// What speaks against the filter's calibration beside the one from segments of the same recordings; empty: nothing.
/// A filter linearises each point once, where it believes itself to be then: from a poor start it can be a hundred of
/// its sigmas off, and its residuals do not show it. A fit over all segments linearises until it stays. Both have the
/// same data, so that an honest difference has at most the sum of both variances, and its mean square over the values
/// that both release is 1 at most: 0.2 to 1.2 in simulation, where the filter is within five sigmas. 1.5, or 3.5 sigmas
/// of one value, which chance makes once in a hundred recordings, is no calibration.
std::string against_joint_filter(const CoreResult& filter, const CoreResult& segments);

/// Takes `calibrated` back where something does, or where no calibration from segments is there to tell.
void judge_joint_filter(const std::vector<Recording>& sessions, const ReplayOptions& options, ReplayResult* out);

}  // namespace host::review
