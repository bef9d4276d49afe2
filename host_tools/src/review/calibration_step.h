// Did a part of the calibration change on the way? A mount that was bent, a lens that was turned, too late for the
// device to find: it drops older segments once newer ones know enough by themselves, and from one or two nobody can
// calibrate.
#pragma once

#include <optional>

#include "replay/replay.h"

namespace host::review {

/// The step of one block of theta between two kept segments, or within one, that is most significant with all else free
/// (diagnose/shift.h, with one segment on a side enough), by F against what the segments scatter beside it. `moves`:
/// what the calibration after the step is from the released one; empty where scatter and the number of trials explain
/// it.
std::optional<Suspect> calibration_step(const std::vector<Recording>& sessions, Core& core, const ReplayResult& result);

}  // namespace host::review
