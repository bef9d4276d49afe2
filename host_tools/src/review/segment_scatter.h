// Do the segments agree with each other? The sandwich covariance of a calibration, each segment a cluster of its own.
#pragma once

#include "diagnose/selection.h"

namespace host::review {

/// With theta at its best, segment s still pulls with g_s = R_s'(d_s - R_s x). If residuals are independent noise of
/// variance c, the covariance of the pulls is c (H_s - H_s Sigma H_s), with H_s = R_s'R_s and Sigma the model's
/// covariance. Errors that last for a whole segment (tracks that drift, a calibration that moves, an effect without a
/// name) make them larger, and the covariance of theta is Sigma (sum of g_s g_s') Sigma instead (White, "Maximum
/// likelihood estimation of misspecified models", Econometrica 1982; Liang and Zeger, Biometrika 1986).
struct SegmentScatter {
  double pooled = 1;                ///< variance of all pulls over the dispersion's
  double pooled_dof = 0;            ///< of that ratio, as a chi-square number over its degrees of freedom
  double log10_p = 0;               ///< that the pulls are noise
  Eigen::VectorXd variance_factor;  ///< on the variance of each printed value, >= 1; 1 where the scatter may be chance
};

/// `printed`: rows of printed values over theta's columns; `dispersion`: variance that the released sigmas have been
/// scaled for, which holds the mean over all directions already (lib/src/calibration/scatter.h): what is found here is
/// single values that scatter more.
SegmentScatter scatter_of_segments(const diagnosis::Problem& problem, const Eigen::MatrixXd& printed,
                                   double dispersion);

}  // namespace host::review
