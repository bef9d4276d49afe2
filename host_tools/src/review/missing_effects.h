// The score test of the catalogue at a finished calibration: which effect outside the model would explain what it
// leaves, and how far would theta move with it?
#pragma once

#include <string>
#include <vector>

#include "replay/replay.h"
#include "review/unseen_effects.h"

namespace host::review {

/// Effects that the calibration's rows ask for: significant after correction for the number of effects and against the
/// scatter of their own value over the segments, or against that moderated by the scatter of all values, which tells
/// more where segments are few; halves of the recording agree and help each other. Certain ones first, then by their
/// statistics. Those that are significant only if the scatter of so few segments is taken for exact are not certain.
/// `unseen`: those that the data do not ask for.
/// Where `sessions` have exposures, exposure_offset is asked about as well (diagnose/exposure_offset.h).
std::vector<Suspect> missing_effects(Core& core, const ReplayResult& result, const std::vector<Recording>& sessions,
                                     bool has_temperature, std::vector<UnseenEffect>* unseen);

}  // namespace host::review
