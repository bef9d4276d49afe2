// When a fit counts as converged, and what it looks like at its end.
#pragma once

#include "math/types.h"

namespace SEGCAL_NS {

struct CalibratorOptions {
  int max_iterations = 30;
  /// Squared length of a step of theta, in sigmas: below 0.06 sigma the fit counts as converged, and goes on to 0.02
  /// sigma as long as there are iterations left.
  double converged = 4e-3, settled = 4e-4;
  /// At the last iteration, where the cost is flat: corner tracks with tails make robust weights swing to and fro about
  /// the minimum. Half a sigma beside it adds 12 % to an error of one sigma; refusing the fit would leave nothing.
  double swings = 0.25;
};

/// What the fit looks like at its end.
template <class S>
struct CalibrationFit {
  bool converged = false;
  std::int32_t iterations = 0;
  std::int32_t image_points = 0;
  S start_cost = S(0), cost = S(0);  ///< robust
  S chi2 = S(0), dof = S(0);         ///< weighted squares at the end and their degrees of freedom
};

}  // namespace SEGCAL_NS
