// The score test of the catalogue at a finished calibration: which effect outside the model would explain what it
// leaves, and how far would theta move with it?
#pragma once

#include <string>
#include <vector>

#include "replay/replay.h"

namespace host::review {

/// Effects that the calibration's rows ask for: significant after correction for the number of effects, and halves of
/// the recording agree and help each other.
struct MissingEffects {
  std::vector<Suspect> called;  ///< against the scatter of the effect's own value over the segments alone
  /// Only where the scatter of theta's values says how far values of this recording scatter: four segments know one
  /// value's scatter so badly that 30 of its sigmas may be chance. Said, and no reason to refuse a calibration.
  std::vector<Suspect> likely;
};
MissingEffects missing_effects(Core& core, const ReplayResult& result, bool has_temperature);

/// The most that one of them moves a released value by, in its sigmas.
double most_moved(const std::vector<Suspect>& suspects);

}  // namespace host::review
