// What is known beside image points and IMU links, as residuals: priors, the gauge, and biases that walk over a gap.
#pragma once

#include "reference/imu_residual.h"
#include "reference/theta.h"

namespace host::reference {

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

/// An inverse distance over its sigma, which is `sigma` in front of the camera.
template <class T>
T over_depth_sigma(const T& inverse_distance, double sigma) {
  return inverse_distance / T(inverse_distance < T(0) ? behind_inverse_depth_sigma : sigma);
}

/// Of a landmark from the camera that saw it first.
struct DepthPrior {
  const CameraCalibration& camera0;
  const State& state0;
  const Landmark& landmark0;
  template <class T>
  bool operator()(const T* landmark, const T* pose, const T* camera, T* residual) const {
    const Vector3<T> h = in_camera(camera0, state0, landmark0, pose, landmark, camera);
    residual[0] = over_depth_sigma<T>(landmark[2] / h.norm(), landmark0.prior_sigma);
    return true;
  }
};

/// Of a tie, from its anchor: no segment's camera is the first.
struct TieDepthPrior {
  double sigma;  ///< 1/m
  template <class T>
  bool operator()(const T* landmark, T* residual) const {
    residual[0] = over_depth_sigma<T>(landmark[2], sigma);
    return true;
  }
};

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
    for (int i = 0; i < 4; ++i)
      residual[10 + i] = i < lens_parameters(mean) ? camera[10 + i] - T(mean.distortion(i)) : T(0);
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

/// Where the world stands is free but for the priors of ties, which count from fixed points (calibration/ties.h).
struct Gauge {
  const State& state;
  template <class T>
  bool operator()(const T* pose, T* residual) const {
    constexpr double weight = 1e5;
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

}  // namespace host::reference
