// A reference problem as Ceres sees it: parameter blocks and residual blocks.
#pragma once

#include <ceres/ceres.h>

#include <array>
#include <map>
#include <memory>

#include "reference/imu_residual.h"

namespace host::reference {

class CeresProblem {
 public:
  /// `problem` must outlive this object; it is changed by take_over() alone.
  explicit CeresProblem(const Problem& problem);

  ceres::Problem& ceres() { return ceres_; }
  /// Landmarks first, then the rest: the Schur complement's order.
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering();
  std::vector<const double*> theta_blocks() const;
  /// The unknowns one after the other: landmarks, states (pose, then
  /// motion), theta. Without drifts of tracks (CoreModel::track_walk).
  std::vector<double*> blocks();
  /// Residual blocks of the links, then of the walks over gaps, in the problem's order.
  const std::vector<ceres::ResidualBlockId>& motion_residuals() const { return motion_residuals_; }
  /// Residuals that are measurements, minus unknowns without a prior of their own; weak priors count for neither.
  double degrees_of_freedom() const;
  int image_points() const { return image_points_; }
  int partitions() const { return static_cast<int>(problem_.gauges.size()); }
  /// Puts the present values into `problem`, the one this was made from.
  void take_over(Problem* problem) const;

 private:
  using Pose = std::array<double, kPoseSize>;
  using Motion = std::array<double, kMotionSize>;
  void fill();
  void add_points();
  void add_depth_prior(std::size_t landmark);
  double depth_prior_slope(std::size_t landmark) const;
  void add_motion();
  void add_priors();
  double prior_share(std::size_t landmark) const;
  double* add_drift(std::size_t point);
  double drift_variance(std::size_t from, std::size_t to) const;
  double step_variance(std::size_t from, std::size_t to) const;
  Eigen::MatrixXd point_covariance(const std::vector<std::size_t>& points, const std::vector<double>& weights) const;
  bool used(std::size_t landmark) const { return points_of_[landmark] >= 2; }

  const Problem& problem_;
  ceres::Problem ceres_;
  std::vector<Pose> pose_;
  std::vector<Motion> motion_;
  std::vector<std::array<double, kLandmarkSize>> landmark_;
  std::vector<std::array<double, kCameraSize>> camera_;
  std::array<double, kImuSize> imu_{};
  std::vector<int> points_of_;
  std::vector<std::size_t> first_point_;               ///< per landmark
  std::vector<ceres::ResidualBlockId> depth_prior_;    ///< per landmark that is used
  std::vector<std::array<double, 2>> drift_;           ///< px, per point
  std::vector<int> drift_before_;                      ///< point of the same track before; -1: it begins there
  std::vector<ceres::ResidualBlockId> block_;          ///< per point that is used
  std::vector<std::vector<std::size_t>> used_points_;  ///< per landmark
  std::vector<ceres::ResidualBlockId> motion_residuals_;
  std::map<std::array<int, 3>, int> track_;  ///< segment, landmark, camera: the last point added
  int image_points_ = 0;
};

}  // namespace host::reference
