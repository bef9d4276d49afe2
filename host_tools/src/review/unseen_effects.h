// What sigmas cannot hold: an effect outside the model that a calibration absorbs leaves no residual to be found by.
#pragma once

#include "diagnose/selection.h"
#include "replay/replay.h"

namespace host::review {

/// The effect's terms c beside theta, their plausible sizes being the prior: the covariance of theta is larger by
/// (dtheta/dc) P_c (dtheta/dc)', P_c being what the data leave of c. (Consider analysis, Bierman, Factorization Methods
/// for Discrete Sequential Estimation, 1977, chapter VIII, has the prior's P_c.) `variance`: of the rows' noise, in
/// units of what they were weighed by.
UnseenEffect unseen_effect(const diagnosis::Problem& problem, const diagnosis::Candidate& candidate, double variance,
                           const std::vector<CoreParameter>& parameters);

/// The note `unseen_effects` of a calibrated result, at its sigmas as they are now: the effects that may move a
/// released value by more than `kMostBias` of them, the worst first. None is left of a result that is not calibrated,
/// nor of an effect that is suspected: sigmas hold that.
void note_unseen_effects(ReplayResult* result);

}  // namespace host::review
