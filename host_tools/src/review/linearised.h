// The rows of a finished calibration, for questions about it: all kept segments together, halves of them, each alone.
#pragma once

#include "diagnose/evidence.h"
#include "diagnose/selection.h"
#include "replay/replay.h"

namespace host::review {

/// The kept segments as they followed each other: the clock of a later session may begin anew.
std::vector<const CoreKept*> in_order(const ReplayResult& result);

/// Columns [theta with the terms that were estimated | candidates' terms]. Theta's columns count from the released
/// values, rotations as small rotations from the left. The prior's mean is the start. No pieces, where fewer than two
/// segments are kept; pieces in order, on a time scale on which
/// sessions follow each other without a gap. Throws InputError for candidates that the profile has no room for.
diagnosis::Problem linearised(Core& core, const ReplayResult& result,
                              const std::vector<diagnosis::TermInfo>& candidates);

/// Printed values by small rotations: for each parameter, how it moves with theta's columns.
Eigen::MatrixXd printed_by_columns(const std::vector<CoreParameter>& parameters);

/// The step from the start in theta's columns.
Eigen::VectorXd step_from_start(const std::vector<CoreParameter>& parameters);

}  // namespace host::review
