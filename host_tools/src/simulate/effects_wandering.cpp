#include "effects_wandering.h"

#include <Eigen/Geometry>
#include <cmath>

#include "../angles.h"
#include "imu_simulator.h"
#include "random.h"

namespace host::sim {
namespace {

constexpr double hunting_period_s = 7, wandering_period_s = 11, mount_period_s = 1.7, hum_Hz = 1.3;

double wave(double t, double period_s) { return std::sin(two_pi * t / period_s); }

}  // namespace

void FocusHunting::on_camera_calibration(const CameraMoment& moment, CameraCalibration& calibration) const {
  const double factor = 1 + k_ * wave(moment.t, hunting_period_s);
  calibration.intrinsics[0] *= factor;
  calibration.intrinsics[1] *= factor;
}

void LooseMount::on_camera_calibration(const CameraMoment& moment, CameraCalibration& calibration) const {
  Random side(static_cast<std::uint64_t>(std::llround(std::floor(moment.t / mount_period_s) + 1000)), Stream::device);
  const double angle = side.uniform() < 0.5 ? -angle_ : angle_;
  calibration.R_CI = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()) * calibration.R_CI;
}

double WanderingStamps::exposure_time(const CameraCalibration&, double t_stamp, double) const {
  return t_stamp + k_ * wave(t_stamp, wandering_period_s);
}

void GyroHum::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  reading.gyro += Eigen::Vector3d::Constant(k_ * wave(moment.t, 1 / hum_Hz));
}

double TwoWayShutter::exposure_time(const CameraCalibration& camera, double t_stamp, double line) const {
  return t_stamp + k_ * (std::abs(line - camera.lines() / 2.0) - camera.lines() / 4.0);
}

}  // namespace host::sim
