#include "effects_camera.h"

#include <Eigen/Geometry>

namespace host::sim {

Eigen::Vector2d normalised(const CameraCalibration& camera, const Eigen::Vector2d& pixel) {
  return (pixel - camera.intrinsics.tail<2>()).cwiseQuotient(camera.intrinsics.head<2>());
}

Eigen::Vector2d in_pixels(const CameraCalibration& camera, const Eigen::Vector2d& d) {
  return d.cwiseProduct(camera.intrinsics.head<2>()) + camera.intrinsics.tail<2>();
}

void RadialResidual::on_pixel(const CameraCalibration& camera, double, Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d d = normalised(camera, pixel);
  pixel = in_pixels(camera, d * (1 + k_ * d.squaredNorm()));
}

void TangentialResidual::on_pixel(const CameraCalibration& camera, double, Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d d = normalised(camera, pixel);
  const double x = d.x(), y = d.y(), r2 = d.squaredNorm();
  const Eigen::Vector2d moved(x + 2 * p1_ * x * y + p2_ * (r2 + 2 * x * x),
                              y + p1_ * (r2 + 2 * y * y) + 2 * p2_ * x * y);
  pixel = in_pixels(camera, moved);
}

EffectTruth CameraTemperature::truth() const {
  EffectTruth out{"camera_temperature", {}};
  const char* const turns[] = {"rx", "ry", "rz"};
  for (int i = 0; i < 3; ++i) out.parameters.push_back({turns[i], turn_[i], "1/degC"});
  out.parameters.push_back({"f", focal_, "1/degC"});
  out.parameters.push_back({"cx", centre_.x(), "1/degC"});
  out.parameters.push_back({"cy", centre_.y(), "1/degC"});
  return out;
}

void CameraTemperature::on_camera_calibration(const CameraMoment& moment, CameraCalibration& calibration) const {
  const double warmer = moment.temperature_degC - reference_temperature_degC, angle = turn_.norm() * warmer;
  if (angle != 0) calibration.R_CI = Eigen::AngleAxisd(angle, turn_.normalized()).toRotationMatrix() * calibration.R_CI;
  const Eigen::Vector2d focal = calibration.intrinsics.head<2>();
  calibration.intrinsics.head<2>() += warmer * focal_ * focal;
  calibration.intrinsics.tail<2>() += warmer * centre_.cwiseProduct(focal);
}

}  // namespace host::sim
