// How many numbers a fit of a CeresProblem may count as measured, less those that it fitted.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "reference/ceres_problem.h"
#include "reference/theta.h"

namespace host::reference {

/// px^2, of a track's walk from one point to the other by its robust weight at the present estimate.
double CeresProblem::step_variance(std::size_t from, std::size_t to) const {
  const double variance = drift_variance(from, to);
  const double e = std::hypot(drift_[to][0] - drift_[from][0], drift_[to][1] - drift_[from][1]) / std::sqrt(variance);
  return variance * std::max(1.0, e / problem_.model.huber);
}

/// Covariance of a landmark's image points in units of the pixel sigma squared, of one axis: white noise by its robust
/// weight, and the walks of the tracks.
Eigen::MatrixXd CeresProblem::point_covariance(const std::vector<std::size_t>& points,
                                               const std::vector<double>& weights) const {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      if (static_cast<int>(points[static_cast<std::size_t>(j)]) != drift_before_[points[static_cast<std::size_t>(i)]])
        continue;
      C.row(i).head(i) = C.row(j).head(i);
      C(i, i) = C(j, j) + step_variance(points[static_cast<std::size_t>(j)], points[static_cast<std::size_t>(i)]) /
                              std::pow(problem_.model.pixel_sigma, 2);
      C.col(i).head(i) = C.row(i).head(i);
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) C(i, i) += 1 / weights[static_cast<std::size_t>(i)];
  return C;
}

/// Of the prior's residual by the landmark's inverse distance.
double CeresProblem::depth_prior_slope(std::size_t landmark) const {
  std::vector<double*> parameters;
  ceres_.GetParameterBlocksForResidualBlock(depth_prior_[landmark], &parameters);
  double r = 0, J[kLandmarkSize] = {};
  double* jacobians[3] = {J, nullptr, nullptr};
  ceres_.GetCostFunctionForResidualBlock(depth_prior_[landmark])->Evaluate(parameters.data(), &r, jacobians);
  return J[2];
}

/// Part of what is known of a landmark's inverse distance that
/// comes from its prior: so much of an unknown is not fitted.
double CeresProblem::prior_share(std::size_t landmark) const {
  const double slope = depth_prior_slope(landmark), prior = slope * slope;
  const std::vector<std::size_t>& points = used_points_[landmark];
  std::vector<double> weights;
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd J[2] = {Eigen::MatrixXd(n, 3), Eigen::MatrixXd(n, 3)};
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<double*> parameters;
    ceres_.GetParameterBlocksForResidualBlock(block_[points[i]], &parameters);
    double r[2];
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_point;
    double* jacobians[4] = {nullptr, J_point.data(), nullptr, nullptr};
    ceres_.GetCostFunctionForResidualBlock(block_[points[i]])->Evaluate(parameters.data(), r, jacobians);
    weights.push_back(std::min(1.0, problem_.model.huber / std::hypot(r[0], r[1])));
    for (int axis = 0; axis < 2; ++axis) J[axis].row(static_cast<Eigen::Index>(i)) = J_point.row(axis);
  }
  const Eigen::LLT<Eigen::MatrixXd> C(point_covariance(points, weights));
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  H(2, 2) = prior;
  for (const Eigen::MatrixXd& J_axis : J) H += J_axis.transpose() * C.solve(J_axis);
  return std::min(1.0, prior * H.inverse()(2, 2));
}

double CeresProblem::degrees_of_freedom() const {
  double residuals = 2.0 * image_points_ + kLinkRows * static_cast<double>(problem_.links.size()) +
                     6.0 * static_cast<double>(problem_.walks.size());
  double unknowns = 15.0 * static_cast<double>(pose_.size()) + kImuSize;
  unknowns -=
      4.0 * static_cast<double>(problem_.gauges.size()) + 6.0 * static_cast<double>(problem_.chain_starts.size());
  for (const CameraCalibration& c : problem_.theta.cameras) unknowns += camera_parameters(c);
  for (std::size_t l = 0; l < landmark_.size(); ++l) unknowns += used(l) ? 3 - prior_share(l) : 0;
  return residuals - unknowns;
}

}  // namespace host::reference
