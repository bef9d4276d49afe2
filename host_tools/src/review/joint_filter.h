// Is the joint filter where its sigmas say?
//
// A filter linearises each point once, where it believes itself to be then. From a poor start it can be fifty of its
// sigmas off, and where the device rests now and then it may believe ten times as much as its data tell; its residuals
// show neither. A fit over all segments of the same data linearises until it stays.
#pragma once

#include "replay/replay.h"

namespace host::review {

/// What speaks against the filter's calibration beside the one from all segments; empty: nothing. Both have the same
/// data, so that an honest difference has at most the sum of both variances, and its mean square over the values that
/// both release is 1 at most: 0.2 to 1.2 in simulation, where the filter is within five sigmas. 1.5, or 3.5 sigmas of
/// one value, which chance makes once in a hundred recordings, is no calibration.
std::string against_joint_filter(const CoreResult& filter, const CoreResult& segments);

/// A fit over all of the data knows what there is to know: the filter's sigmas become at least those of the segments,
/// its covariance with them, and verdicts follow.
void claim_no_more(const CoreResult& segments, CoreResult* filter);

/// Both, with the segments of these recordings; takes `calibrated` back also where they give no calibration to tell.
void judge_joint_filter(const std::vector<Recording>& sessions, const ReplayOptions& options, ReplayResult* out);

}  // namespace host::review
