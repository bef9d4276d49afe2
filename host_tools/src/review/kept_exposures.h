// Exposures of the segments that a calibration was made of.
#pragma once

#include <vector>

#include "replay/replay.h"

namespace host::review {

/// Mean exposure of each kept segment's keyframes, in their order (linearised.h); empty where the recordings have no
/// exposures, or not for all segments, as where some are of sessions before a restored state.
std::vector<double> kept_exposures(const ReplayResult& result, const std::vector<Recording>& sessions);

}  // namespace host::review
