#include "effects_camera.h"

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

}  // namespace host::sim
