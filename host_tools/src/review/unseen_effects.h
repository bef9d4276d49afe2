// What sigmas cannot hold: an effect outside the model that a calibration absorbs leaves no residual to be found by.
#pragma once

#include "diagnose/selection.h"
#include "replay/replay.h"

namespace host::review {

/// An effect of the catalogue that the data do not ask for.
struct UnseenEffect {
  std::string name;
  std::vector<double> moves;  ///< of each parameter, in its unit: standard deviation of what the effect may move it by
};

/// Consider analysis (Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, chapter VIII): with the
/// effect's terms c beside theta, their plausible sizes being the prior, the covariance of theta is larger by
/// (dtheta/dc) P_c (dtheta/dc)'.
UnseenEffect unseen_effect(const diagnosis::Problem& problem, const diagnosis::Candidate& candidate,
                           const std::vector<CoreParameter>& parameters);

/// One note with the worst of them and the value that each moves most, in its stated sigmas; none where all stay below
/// `kMostBias`.
std::vector<Note> notes_on_unseen(const std::vector<UnseenEffect>& effects,
                                  const std::vector<CoreParameter>& parameters);

}  // namespace host::review
