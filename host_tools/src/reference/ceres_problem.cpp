#include "reference/ceres_problem.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

namespace host::reference {
namespace {

int lens_parameters(const CameraCalibration& camera) { return camera.model == DistortionModel::fov ? 1 : 4; }

/// (values - about) / sigma, N at a time, from entry `first` of a block on.
template <int Block, int N>
struct WeakPrior {
  int first;
  double about[N], sigma[N];
  template <class T>
  bool operator()(const T* block, T* residual) const {
    for (int i = 0; i < N; ++i) residual[i] = (block[first + i] - T(about[i])) / T(sigma[i]);
    return true;
  }
};

template <int Block, int N>
ceres::CostFunction* weak_prior(int first, double about, double sigma) {
  auto* f = new WeakPrior<Block, N>{first, {}, {}};
  for (int i = 0; i < N; ++i) {
    f->about[i] = about;
    f->sigma[i] = sigma;
  }
  return new ceres::AutoDiffCostFunction<WeakPrior<Block, N>, N, Block>(f);
}

/// Log(Exp(turn) R0 mean') in the first three entries of `out`.
template <class T>
Vector3<T> turn_from(const T* turn, const Eigen::Matrix3d& R0, const Eigen::Matrix3d& mean) {
  return rotation_vector<T>(turned_by(turn) * Eigen::Quaterniond(Eigen::Matrix3d(R0 * mean.transpose())).cast<T>());
}

struct CameraPrior {
  CameraCalibration camera0, mean;
  const double* sigma;
  template <class T>
  bool operator()(const T* camera, T* residual) const {
    Eigen::Map<Vector3<T>>{residual} = turn_from(camera, camera0.R_CI, mean.R_CI);
    for (int i = 0; i < 3; ++i) residual[3 + i] = camera[3 + i] - T(mean.p_CI(i));
    for (int i = 0; i < 4; ++i) residual[6 + i] = camera[6 + i] - T(mean.intrinsics(i));
    for (int i = 0; i < 4; ++i) residual[10 + i] = i < lens_parameters(mean) ? camera[10 + i] - T(mean.distortion(i)) : T(0);
    for (int i = 0; i < camera_parameters(mean); ++i) residual[i] /= T(sigma[i]);
    return true;
  }
};

struct ImuPrior {
  Eigen::Matrix3d R_AI0;
  ImuCalibration mean;
  const double* sigma;
  template <class T>
  bool operator()(const T* imu, T* residual) const {
    double about[kImuSize];
    imu_block(mean, about);
    for (int i = 0; i < 12; ++i) residual[i] = imu[i] - T(about[i]);
    Eigen::Map<Vector3<T>>{residual + 12} = turn_from(imu + 12, R_AI0, mean.R_AI);
    for (int i = 0; i < kImuSize; ++i) residual[i] /= T(sigma[i]);
    return true;
  }
};

/// Where the world stands is exactly free, so that any weight holds it.
struct Gauge {
  const State& state;
  template <class T>
  bool operator()(const T* pose, T* residual) const {
    constexpr double weight = 1e3;
    for (int i = 0; i < 3; ++i) residual[i] = T(weight) * (pose[3 + i] - T(state.p_GI(i)));
    const Vector3<T> turn_G = state.q_GI.cast<T>() * Vector3<T>(pose[0], pose[1], pose[2]);
    residual[3] = T(weight) * turn_G.z();
    return true;
  }
};

struct BiasResidual {
  double sigma_a, sigma_g;
  template <class T>
  bool operator()(const T* from, const T* to, T* residual) const {
    for (int i = 0; i < 6; ++i) residual[i] = (to[3 + i] - from[3 + i]) / T(i < 3 ? sigma_a : sigma_g);
    return true;
  }
};

}  // namespace

int camera_parameters(const CameraCalibration& camera) { return 10 + lens_parameters(camera); }

CeresProblem::CeresProblem(const Problem& problem) : problem_(problem) {
  fill();
  add_points();
  add_motion();
  add_priors();
}

void CeresProblem::fill() {
  for (const State& x : problem_.states) {
    pose_.push_back({0, 0, 0, x.p_GI.x(), x.p_GI.y(), x.p_GI.z()});
    motion_.push_back({x.v_GI.x(), x.v_GI.y(), x.v_GI.z(), x.b_a.x(), x.b_a.y(), x.b_a.z(), x.b_g.x(), x.b_g.y(), x.b_g.z()});
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
}

/// The drift of a point, and its step from the point of the track before; null at the track's beginning, from where it counts.
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
  auto* f = new ceres::AutoDiffCostFunction<DriftStep, 2, 2, 2>(new DriftStep{std::sqrt(drift_variance(before, point))});
  ceres_.AddResidualBlock(f, new ceres::HuberLoss(problem_.model.huber), drift_[before].data(), drift_[point].data());
  if (drift_before_[before] < 0) ceres_.SetParameterBlockConstant(drift_[before].data());
  return drift_[point].data();
}

/// px^2, of the walk from one point to the other.
double CeresProblem::drift_variance(std::size_t from, std::size_t to) const {
  const auto time = [this](std::size_t i) { return problem_.states[static_cast<std::size_t>(problem_.points[i].state)].t_ns; };
  return std::pow(problem_.model.track_walk, 2) * 1e-9 * static_cast<double>(time(to) - time(from));
}

/// The same by its robust weight at the present estimate.
double CeresProblem::step_variance(std::size_t from, std::size_t to) const {
  const double variance = drift_variance(from, to);
  const double e = std::hypot(drift_[to][0] - drift_[from][0], drift_[to][1] - drift_[from][1]) / std::sqrt(variance);
  return variance * std::max(1.0, e / problem_.model.huber);
}

void CeresProblem::add_points() {
  auto* const loss = new ceres::HuberLoss(problem_.model.huber);  // one for all: Ceres deletes it once
  for (std::size_t i = 0; i < problem_.points.size(); ++i) {
    const Point& z = problem_.points[i];
    const auto l = static_cast<std::size_t>(z.landmark), k = static_cast<std::size_t>(z.state), c = static_cast<std::size_t>(z.camera);
    if (z.rejected || !used(l)) continue;
    const CameraResidual f{problem_.theta.cameras[c], problem_.states[k], problem_.landmarks[l], z.uv, problem_.model.pixel_sigma,
                           problem_.model.huber};
    double* const drift = add_drift(i);
    if (drift) {
      block_[i] = ceres_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<DriftingResidual, 2, kPoseSize, kLandmarkSize, kCameraSize, 2>(new DriftingResidual{f}), loss,
          pose_[k].data(), landmark_[l].data(), camera_[c].data(), drift);
    } else {
      block_[i] = ceres_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<CameraResidual, 2, kPoseSize, kLandmarkSize, kCameraSize>(new CameraResidual(f)), loss,
          pose_[k].data(), landmark_[l].data(), camera_[c].data());
    }
    used_points_[l].push_back(i);
    ++image_points_;
  }
  if (image_points_ == 0) delete loss;
  for (std::size_t l = 0; l < landmark_.size(); ++l) {
    if (!used(l)) continue;
    ceres_.AddResidualBlock(weak_prior<kLandmarkSize, 1>(2, 0, problem_.landmarks[l].prior_sigma), nullptr, landmark_[l].data());
  }
}

void CeresProblem::add_motion() {
  for (const Link& link : problem_.links) {
    const auto a = static_cast<std::size_t>(link.from), b = static_cast<std::size_t>(link.to);
    ceres_.AddResidualBlock(new LinkResidual(problem_, link), nullptr, pose_[a].data(), motion_[a].data(), pose_[b].data(),
                            motion_[b].data(), imu_.data());
  }
  for (const BiasWalk& walk : problem_.walks) {
    const double root = std::sqrt(walk.gap_s);
    auto* f = new BiasResidual{problem_.model.accel_random_walk * root, problem_.model.gyro_random_walk * root};
    ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<BiasResidual, 6, kMotionSize, kMotionSize>(f), nullptr,
                            motion_[static_cast<std::size_t>(walk.from)].data(), motion_[static_cast<std::size_t>(walk.to)].data());
  }
}

void CeresProblem::add_priors() {
  const double* sigma = problem_.prior_sigma.data();
  for (std::size_t c = 0; c < camera_.size(); ++c) {
    auto* f = new CameraPrior{problem_.theta.cameras[c], problem_.prior_mean.cameras[c], sigma};
    ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<CameraPrior, kCameraSize, kCameraSize>(f), nullptr, camera_[c].data());
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
    ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<Gauge, 4, kPoseSize>(g), nullptr, pose_[static_cast<std::size_t>(k)].data());
  }
  for (const int k : problem_.segment_starts) {
    ceres_.AddResidualBlock(weak_prior<kMotionSize, 3>(0, 0, problem_.model.velocity_sigma), nullptr, motion_[static_cast<std::size_t>(k)].data());
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
    if (drift_before_[i] >= 0 || ceres_.HasParameterBlock(drift_[i].data())) out->AddElementToGroup(drift_[i].data(), 1);
  }
  for (auto& c : camera_) out->AddElementToGroup(c.data(), 1);
  out->AddElementToGroup(imu_.data(), 1);
  return out;
}

std::vector<const double*> CeresProblem::theta_blocks() const {
  std::vector<const double*> out;
  for (const auto& c : camera_) out.push_back(c.data());
  out.push_back(imu_.data());
  return out;
}

/// Covariance of a landmark's image points in units of the pixel sigma squared, of one axis: white noise by its robust weight,
/// and the walks of the tracks.
Eigen::MatrixXd CeresProblem::point_covariance(const std::vector<std::size_t>& points, const std::vector<double>& weights) const {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      if (static_cast<int>(points[static_cast<std::size_t>(j)]) != drift_before_[points[static_cast<std::size_t>(i)]]) continue;
      C.row(i).head(i) = C.row(j).head(i);
      C(i, i) = C(j, j) + step_variance(points[static_cast<std::size_t>(j)], points[static_cast<std::size_t>(i)]) /
                              std::pow(problem_.model.pixel_sigma, 2);
      C.col(i).head(i) = C.row(i).head(i);
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) C(i, i) += 1 / weights[static_cast<std::size_t>(i)];
  return C;
}

/// Part of what is known of a landmark's inverse distance that comes from its prior: so much of an unknown is not fitted.
double CeresProblem::prior_share(std::size_t landmark) const {
  const double sigma = problem_.landmarks[landmark].prior_sigma, prior = 1 / (sigma * sigma);
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
  double residuals = 2.0 * image_points_ + kLinkRows * static_cast<double>(problem_.links.size()) + 6.0 * static_cast<double>(problem_.walks.size());
  double unknowns = 15.0 * static_cast<double>(pose_.size()) + kImuSize;
  unknowns -= 4.0 * static_cast<double>(problem_.gauges.size()) + 6.0 * static_cast<double>(problem_.chain_starts.size());
  for (const CameraCalibration& c : problem_.theta.cameras) unknowns += camera_parameters(c);
  for (std::size_t l = 0; l < landmark_.size(); ++l) unknowns += used(l) ? 3 - prior_share(l) : 0;
  return residuals - unknowns;
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
