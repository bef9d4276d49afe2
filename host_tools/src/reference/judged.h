// From a fit to a result: which parameters are observed, how well, and what stays where it was.
#pragma once

#include "reference/solve.h"

namespace host::reference {

/// The result as replay has it: verdicts, sigmas scaled by what the fit shows, status. Parameters that are not observed
/// go back to where they started, and the others follow (which moves the problem's estimate).
CoreResult judged(Problem* problem, const Fit& fit, const SolveOptions& options);

}  // namespace host::reference
