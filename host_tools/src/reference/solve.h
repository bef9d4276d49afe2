// Solves a reference problem with Ceres and says how well theta is known.
#pragma once

#include <functional>
#include <string>

#include "reference/problem.h"

namespace host::reference {

struct SolveOptions {
  int threads = 1;
  int rounds = 8;                                    ///< at most; in each the weights of the IMU links are taken anew
  int iterations = 200;                              ///< at most, of one round
  std::function<void(const std::string&)> progress;  ///< one line now and then; may be empty
};

/// Numbers of a finished fit.
struct Fit {
  bool converged = false;
  int iterations = 0, image_points = 0, partitions = 0;
  double start_cost = 0, cost = 0;  ///< robust
  double chi2 = 0, dof = 0;         ///< weighted squares at the end, and their degrees of freedom
  Eigen::MatrixXd covariance;       ///< of theta, rotations as small turns Exp(d) R; prior included
};

/// Moves theta, states and landmarks to the minimum. The covariance is filled in by the caller, if wanted.
Fit solve(Problem* problem, const SolveOptions& options);

/// Marginal covariance of theta at the problem's present estimate, by ceres::Covariance.
Eigen::MatrixXd theta_covariance(const Problem& problem, int threads);

/// Marks points whose residual is longer than `limit` pixel sigmas; earlier marks are taken back.
void reject_outliers(Problem* problem, double limit);

/// Predicted minus measured, px. False where the landmark has no image.
bool point_residual(const Problem& problem, const Point& point, Eigen::Vector2d* residual);

/// Lengths of the residuals of the points in use, px.
std::vector<double> reprojection_lengths(const Problem& problem);

}  // namespace host::reference
