#include "reference/ceres_problem.h"

#include <algorithm>

#include "reference/prior_residuals.h"

namespace host::reference {

CeresProblem::CeresProblem(const Problem& problem) : problem_(problem) {
  fill();
  add_points();
  add_motion();
  add_priors();
}

void CeresProblem::fill() {
  for (const State& x : problem_.states) {
    pose_.push_back({0, 0, 0, x.p_GI.x(), x.p_GI.y(), x.p_GI.z()});
    motion_.push_back(
        {x.v_GI.x(), x.v_GI.y(), x.v_GI.z(), x.b_a.x(), x.b_a.y(), x.b_a.z(), x.b_g.x(), x.b_g.y(), x.b_g.z()});
  }
  for (const Landmark& l : problem_.landmarks) landmark_.push_back({0, 0, l.inverse_distance});
  for (const CameraCalibration& c : problem_.theta.cameras) {
    camera_.push_back({0, 0, 0, c.p_CI.x(), c.p_CI.y(), c.p_CI.z()});
    std::copy_n(c.intrinsics.data(), 4, camera_.back().begin() + 6);
    std::copy_n(c.distortion.data(), 4, camera_.back().begin() + 10);
  }
  imu_block(problem_.theta.imu, imu_.data());
  for (const Point& z : problem_.points) drift_.push_back({z.drift.x(), z.drift.y()});
  drift_before_.assign(drift_.size(), -1);
  block_.assign(drift_.size(), nullptr);
  points_of_.assign(problem_.landmarks.size(), 0);
  used_points_.resize(problem_.landmarks.size());
  for (const Point& z : problem_.points) points_of_[static_cast<std::size_t>(z.landmark)] += z.rejected ? 0 : 1;
  depth_prior_.assign(problem_.landmarks.size(), nullptr);
  first_point_.assign(problem_.landmarks.size(), 0);
  for (std::size_t i = problem_.points.size(); i-- > 0;)
    first_point_[static_cast<std::size_t>(problem_.points[i].landmark)] = i;
}

/// The drift of a point, and its step from the point of the track
/// before; null at the track's beginning, from where it counts.
double* CeresProblem::add_drift(std::size_t point) {
  const Point& z = problem_.points[point];
  if (!(problem_.model.track_walk > 0)) return nullptr;
  const auto [last, begins] = track_.try_emplace({z.segment, z.landmark, z.camera}, static_cast<int>(point));
  if (begins) {
    drift_[point] = {0, 0};
    return nullptr;
  }
  const auto before = static_cast<std::size_t>(last->second);
  drift_before_[point] = last->second;
  last->second = static_cast<int>(point);
  auto* f =
      new ceres::AutoDiffCostFunction<DriftStep, 2, 2, 2>(new DriftStep{std::sqrt(drift_variance(before, point))});
  ceres_.AddResidualBlock(f, new ceres::HuberLoss(problem_.model.huber), drift_[before].data(), drift_[point].data());
  if (drift_before_[before] < 0) ceres_.SetParameterBlockConstant(drift_[before].data());
  return drift_[point].data();
}

/// px^2, of the walk from one point to the other.
double CeresProblem::drift_variance(std::size_t from, std::size_t to) const {
  const auto time = [this](std::size_t i) {
    return problem_.states[static_cast<std::size_t>(problem_.points[i].state)].t_ns;
  };
  return std::pow(problem_.model.track_walk, 2) * 1e-9 * static_cast<double>(time(to) - time(from));
}

void CeresProblem::add_depth_prior(std::size_t l) {
  const Landmark& landmark = problem_.landmarks[l];
  if (landmark.tie) {
    depth_prior_[l] = ceres_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<TieDepthPrior, 1, kLandmarkSize>(new TieDepthPrior{landmark.prior_sigma}),
        nullptr, landmark_[l].data());
    return;
  }
  const Point& z = problem_.points[first_point_[l]];
  const auto k = static_cast<std::size_t>(z.state), c = static_cast<std::size_t>(z.camera);
  depth_prior_[l] =
      ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<DepthPrior, 1, kLandmarkSize, kPoseSize, kCameraSize>(
                                  new DepthPrior{problem_.theta.cameras[c], problem_.states[k], landmark}),
                              nullptr, landmark_[l].data(), pose_[k].data(), camera_[c].data());
}

void CeresProblem::add_points() {
  auto* const loss = new ceres::HuberLoss(problem_.model.huber);  // one for all: Ceres deletes it once
  for (std::size_t i = 0; i < problem_.points.size(); ++i) {
    const Point& z = problem_.points[i];
    const auto l = static_cast<std::size_t>(z.landmark), k = static_cast<std::size_t>(z.state),
               c = static_cast<std::size_t>(z.camera);
    if (z.rejected || !used(l)) continue;
    const CameraResidual f{problem_.theta.cameras[c],  problem_.states[k],  problem_.landmarks[l], z.uv,
                           problem_.model.pixel_sigma, problem_.model.huber};
    double* const drift = add_drift(i);
    if (drift) {
      block_[i] = ceres_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<DriftingResidual, 2, kPoseSize, kLandmarkSize, kCameraSize, 2>(
              new DriftingResidual{f}),
          loss, pose_[k].data(), landmark_[l].data(), camera_[c].data(), drift);
    } else {
      block_[i] = ceres_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<CameraResidual, 2, kPoseSize, kLandmarkSize, kCameraSize>(
              new CameraResidual(f)),
          loss, pose_[k].data(), landmark_[l].data(), camera_[c].data());
    }
    used_points_[l].push_back(i);
    ++image_points_;
  }
  if (image_points_ == 0) delete loss;
  for (std::size_t l = 0; l < landmark_.size(); ++l) {
    if (used(l)) add_depth_prior(l);
  }
}

void CeresProblem::add_motion() {
  for (const Link& link : problem_.links) {
    const auto a = static_cast<std::size_t>(link.from), b = static_cast<std::size_t>(link.to);
    motion_residuals_.push_back(ceres_.AddResidualBlock(new LinkResidual(problem_, link), nullptr, pose_[a].data(),
                                                        motion_[a].data(), pose_[b].data(), motion_[b].data(),
                                                        imu_.data()));
  }
  for (const BiasWalk& walk : problem_.walks) {
    const double root = std::sqrt(walk.gap_s);
    auto* f = new BiasResidual{problem_.model.accel_random_walk * root, problem_.model.gyro_random_walk * root};
    motion_residuals_.push_back(ceres_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<BiasResidual, 6, kMotionSize, kMotionSize>(f), nullptr,
        motion_[static_cast<std::size_t>(walk.from)].data(), motion_[static_cast<std::size_t>(walk.to)].data()));
  }
}

void CeresProblem::add_priors() {
  const double* sigma = problem_.prior_sigma.data();
  for (std::size_t c = 0; c < camera_.size(); ++c) {
    auto* f = new CameraPrior{problem_.theta.cameras[c], problem_.prior_mean.cameras[c], sigma};
    ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<CameraPrior, kCameraSize, kCameraSize>(f), nullptr,
                            camera_[c].data());
    const int n = camera_parameters(problem_.theta.cameras[c]);
    if (n < kCameraSize) {
      std::vector<int> unused;
      for (int i = n; i < kCameraSize; ++i) unused.push_back(i);
      ceres_.SetManifold(camera_[c].data(), new ceres::SubsetManifold(kCameraSize, unused));
    }
    sigma += n;
  }
  auto* f = new ImuPrior{problem_.theta.imu.R_AI, problem_.prior_mean.imu, sigma};
  ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<ImuPrior, kImuSize, kImuSize>(f), nullptr, imu_.data());
  for (const int k : problem_.gauges) {
    auto* g = new Gauge{problem_.states[static_cast<std::size_t>(k)]};
    ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<Gauge, 4, kPoseSize>(g), nullptr,
                            pose_[static_cast<std::size_t>(k)].data());
  }
  for (const int k : problem_.segment_starts) {
    ceres_.AddResidualBlock(weak_prior<kMotionSize, 3>(0, 0, problem_.model.velocity_sigma), nullptr,
                            motion_[static_cast<std::size_t>(k)].data());
  }
  for (const int k : problem_.chain_starts) {
    double* const motion = motion_[static_cast<std::size_t>(k)].data();
    ceres_.AddResidualBlock(weak_prior<kMotionSize, 3>(3, 0, problem_.model.bias_a_sigma), nullptr, motion);
    ceres_.AddResidualBlock(weak_prior<kMotionSize, 3>(6, 0, problem_.model.bias_g_sigma), nullptr, motion);
  }
}

std::shared_ptr<ceres::ParameterBlockOrdering> CeresProblem::ordering() {
  auto out = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t l = 0; l < landmark_.size(); ++l) {
    if (used(l)) out->AddElementToGroup(landmark_[l].data(), 0);
  }
  for (Pose& x : pose_) out->AddElementToGroup(x.data(), 1);
  for (Motion& x : motion_) out->AddElementToGroup(x.data(), 1);
  for (std::size_t i = 0; i < drift_.size(); ++i) {
    if (drift_before_[i] >= 0 || ceres_.HasParameterBlock(drift_[i].data()))
      out->AddElementToGroup(drift_[i].data(), 1);
  }
  for (auto& c : camera_) out->AddElementToGroup(c.data(), 1);
  out->AddElementToGroup(imu_.data(), 1);
  return out;
}

std::vector<double*> CeresProblem::blocks() {
  std::vector<double*> out;
  for (std::size_t l = 0; l < landmark_.size(); ++l) {
    if (used(l)) out.push_back(landmark_[l].data());
  }
  for (std::size_t k = 0; k < pose_.size(); ++k) {
    out.push_back(pose_[k].data());
    out.push_back(motion_[k].data());
  }
  for (auto& c : camera_) out.push_back(c.data());
  out.push_back(imu_.data());
  return out;
}

std::vector<const double*> CeresProblem::theta_blocks() const {
  std::vector<const double*> out;
  for (const auto& c : camera_) out.push_back(c.data());
  out.push_back(imu_.data());
  return out;
}

void CeresProblem::take_over(Problem* problem) const {
  for (std::size_t k = 0; k < pose_.size(); ++k) {
    State& x = problem->states[k];
    x.q_GI = (x.q_GI * turned_by(pose_[k].data())).normalized();
    x.p_GI = Eigen::Map<const Eigen::Vector3d>(pose_[k].data() + 3);
    x.v_GI = Eigen::Map<const Eigen::Vector3d>(motion_[k].data());
    x.b_a = Eigen::Map<const Eigen::Vector3d>(motion_[k].data() + 3);
    x.b_g = Eigen::Map<const Eigen::Vector3d>(motion_[k].data() + 6);
  }
  for (std::size_t l = 0; l < landmark_.size(); ++l) {
    Landmark& to = problem->landmarks[l];
    const Tangent tangent(to.direction);
    to.direction = (to.direction + landmark_[l][0] * tangent.e1 + landmark_[l][1] * tangent.e2).normalized();
    to.inverse_distance = landmark_[l][2];
  }
  for (std::size_t i = 0; i < drift_.size(); ++i) problem->points[i].drift = {drift_[i][0], drift_[i][1]};
  for (std::size_t c = 0; c < camera_.size(); ++c) {
    CameraCalibration& to = problem->theta.cameras[c];
    to.R_CI = (turned_by(camera_[c].data()) * Eigen::Quaterniond(to.R_CI)).normalized().toRotationMatrix();
    to.p_CI = Eigen::Map<const Eigen::Vector3d>(camera_[c].data() + 3);
    to.intrinsics = Eigen::Map<const Eigen::Vector4d>(camera_[c].data() + 6);
    to.distortion = Eigen::Map<const Eigen::Vector4d>(camera_[c].data() + 10);
  }
  ImuCalibration& imu = problem->theta.imu;
  const auto triangle = [](const double* v) {
    Eigen::Matrix3d T;
    T << v[0], v[3], v[4], 0, v[1], v[5], 0, 0, v[2];
    return T;
  };
  imu.T_g = triangle(imu_.data());
  imu.T_a = triangle(imu_.data() + 6);
  imu.R_AI = (turned_by(imu_.data() + 12) * Eigen::Quaterniond(imu.R_AI)).normalized().toRotationMatrix();
}

}  // namespace host::reference
