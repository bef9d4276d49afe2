// Does a recording show enough for a diagnosis: enough segments, enough motion, and an odometry that follows?
#pragma once

#include "diagnose/diagnose.h"
#include "diagnose/selection.h"

namespace host::diagnosis {

/// `plain`: rows of the fit without effects, `fit`. Where the answer is no, the diagnosis says why.
bool judgeable(const Problem& plain, const std::vector<Candidate>& candidates, const ReplayResult& fit, Diagnosis* out);

}  // namespace host::diagnosis
