#include "camera_model.h"

#include <cmath>

namespace host::sim {
namespace {

constexpr double max_tangent = 5.67;         // tan 80 degrees
constexpr double max_tangent_radtan = 1.73;  // tan 60 degrees
constexpr double tiny_radius = 1e-9;

/// Devernay and Faugeras: r_d = atan(2 r tan(w / 2)) / w.
Eigen::Vector2d distort_fov(const Eigen::Vector2d& x, double w) {
  const double r = x.norm();
  const double gain = 2 * std::tan(w / 2);
  if (r < tiny_radius) return x * gain / w;
  return x * (std::atan(gain * r) / (w * r));
}

/// Brown: k1 k2 radial, p1 p2 tangential.
Eigen::Vector2d distort_radtan(const Eigen::Vector2d& x, const Eigen::Vector4d& k) {
  const double r2 = x.squaredNorm(), xy = x.x() * x.y();
  const double radial = 1 + r2 * (k[0] + r2 * k[1]);
  return {x.x() * radial + 2 * k[2] * xy + k[3] * (r2 + 2 * x.x() * x.x()),
          x.y() * radial + 2 * k[3] * xy + k[2] * (r2 + 2 * x.y() * x.y())};
}

/// Kannala and Brandt: theta_d = theta (1 + k1 theta^2 + .. + k4 theta^8).
Eigen::Vector2d distort_equidistant(const Eigen::Vector2d& x, const Eigen::Vector4d& k) {
  const double r = x.norm();
  if (r < tiny_radius) return x;
  const double theta = std::atan(r), t2 = theta * theta;
  const double theta_d = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  return x * (theta_d / r);
}

bool is_valid(const CameraCalibration& camera, double r2) {
  if (camera.model != DistortionModel::radtan) return r2 < max_tangent * max_tangent;
  if (r2 > max_tangent_radtan * max_tangent_radtan) return false;
  return 1 + 3 * camera.distortion[0] * r2 + 5 * camera.distortion[1] * r2 * r2 > 0;
}

Eigen::Vector2d distorted(const CameraCalibration& camera, const Eigen::Vector2d& x) {
  switch (camera.model) {
    case DistortionModel::fov: return distort_fov(x, camera.distortion[0]);
    case DistortionModel::radtan: return distort_radtan(x, camera.distortion);
    case DistortionModel::equidistant: break;
  }
  return distort_equidistant(x, camera.distortion);
}

}  // namespace

std::optional<Eigen::Vector2d> project(const CameraCalibration& camera, const Eigen::Vector3d& p_C, double border_px) {
  if (p_C.z() <= 0) return std::nullopt;
  const Eigen::Vector2d x = p_C.head<2>() / p_C.z();
  if (!is_valid(camera, x.squaredNorm())) return std::nullopt;
  const Eigen::Vector2d d = distorted(camera, x);
  const Eigen::Vector2d pixel(camera.intrinsics[0] * d.x() + camera.intrinsics[2],
                              camera.intrinsics[1] * d.y() + camera.intrinsics[3]);
  const bool inside = pixel.x() >= border_px && pixel.x() <= camera.width - 1 - border_px &&  //
                      pixel.y() >= border_px && pixel.y() <= camera.height - 1 - border_px;
  if (!inside) return std::nullopt;
  return pixel;
}

}  // namespace host::sim
