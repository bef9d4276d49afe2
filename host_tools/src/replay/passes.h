// What one of several passes over the same recordings did (`segcal replay --passes`).
#pragma once

#include <string>

#include "replay/core.h"

namespace host {

/// Steps of all entries below this share of their sigmas: theta stays. What is left adds half a percent to the error.
constexpr double kPassSettled = 0.1;

struct ReplayPass {
  std::string status;
  int segments = 0, segments_scored = 0;
  std::uint32_t frames_used = 0, filter_restarts = 0;
  double chi2_per_dof = 0;
  /// the largest step from the pass before (of the first: from the start), in this pass' sigmas
  double step_sigmas = 0;
  std::string moved;  ///< the parameter that made it; empty: none was released

  bool settled() const { return status == "calibrated" && step_sigmas < kPassSettled; }
  /// Whether theta is better than before, so that another pass may gain.
  bool goes_on() const { return status == "calibrated" && !settled(); }
};

/// Sets the step of `now`; `before` is the result of the pass before, null for the first.
void measure_step(const CoreResult& now, const CoreResult* before, ReplayPass* pass);

/// "pass 2: calibrated, 8 of 12 segments, 291 images used, chi2/dof 0.98, largest step 0.31 sigma (cam0.p_CI.z)"
std::string in_words(const ReplayPass& pass, std::size_t number);

}  // namespace host
