#include "effects_outside.h"

#include <algorithm>
#include <cmath>

#include "effects_camera.h"
#include "imu_simulator.h"
#include "random.h"

namespace host::sim {
namespace {

constexpr int variance_samples = 8;
constexpr double variance_window_s = 0.5;

}  // namespace

void GyroHysteresis::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  const Eigen::Vector3d& w = moment.state.w_GI;
  if (!began_ || moment.t < last_t_) held_ = w;
  began_ = true;
  last_t_ = moment.t;
  for (int i = 0; i < 3; ++i) held_[i] = std::clamp(held_[i], w[i] - width_, w[i] + width_);
  reading.gyro += moment.imu.T_g * (held_ - w);
}

void VibrationRectification::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();
  for (int k = 0; k < variance_samples; ++k) {
    const BodyState state = moment.truth.at(moment.t - variance_window_s * k / variance_samples);
    const Eigen::Vector3d f = state.R_GI.transpose() * (state.a_GI - gravity_G);
    sum += f;
    squares += f.cwiseAbs2();
  }
  reading.accel += k_ * (squares / variance_samples - (sum / variance_samples).cwiseAbs2());
}

void NoiseWithMotion::on_log(Recording& recording, std::uint64_t seed) const {
  const ImuNoise& stated = recording.imu.noise;
  const double root = std::sqrt(stated.rate_hz);
  Random random(seed + 7, Stream::imu);
  for (ImuSample& s : recording.imu.samples) {
    const double rate = Eigen::Vector3d(s.gyro[0], s.gyro[1], s.gyro[2]).norm();
    for (double& w : s.gyro) w += gyro_ * rate * stated.gyro_noise_density * root * random.normal();
    for (double& f : s.accel) f += accel_ * rate * stated.accel_noise_density * root * random.normal();
  }
}

void AttitudeError::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  const Eigen::Vector3d angles = angles_from_rotation(moment.state.R_GI);
  reading.accel += k_ * Eigen::Vector3d(std::sin(2 * angles.x()), std::sin(2 * angles.y()), 0);
}

void HeadingError::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  const double yaw = angles_from_rotation(moment.state.R_GI).z();
  reading.gyro += k_ * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), std::sin(2 * yaw));
}

void DecentredDistortion::on_pixel(const CameraCalibration& camera, double, Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d d = normalised(camera, pixel), x = d - centre_;
  const double r2 = x.squaredNorm();
  pixel = in_pixels(camera, d + k_ * r2 * r2 * r2 * x);
}

}  // namespace host::sim
