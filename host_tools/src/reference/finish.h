// What both kinds of reference share: solve, judge, hand out.
#pragma once

#include "reference/reference.h"
#include "reference/solve.h"

namespace host::reference {

/// The problem that a replay's calibration solved.
Problem problem_of(const KeptSegments& kept);

State state_of(const CoreState& x);
CoreState core_state_of(const State& x);

/// From a problem with a first estimate to the result.
ReferenceResult finish(Problem* problem, const ReferenceOptions& options);

}  // namespace host::reference
