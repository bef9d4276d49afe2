#include "camera_model.h"

#include <Eigen/LU>
#include <cmath>

namespace host::sim {
namespace {

constexpr double max_tangent = 5.67;             // tan 80 degrees
constexpr double max_angle_equidistant = 1.745;  // 100 degrees
constexpr double max_tangent_radtan = 1.73;      // tan 60 degrees
constexpr double tiny_radius = 1e-9;
constexpr double max_angle_back = 1.536;         // 88 degrees
constexpr double max_radius_back_radtan = 3.73;  // tan 75 degrees
constexpr int newton_steps = 12;
constexpr double newton_converged = 1e-12;

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

/// Kannala and Brandt: theta_d = theta (1 + k1 theta^2 + .. + k4 theta^8), theta from the axis.
Eigen::Vector2d distort_equidistant(const Eigen::Vector2d& x, double theta, const Eigen::Vector4d& k) {
  const double r = x.norm();
  if (r < tiny_radius) return x;
  const double t2 = theta * theta;
  const double theta_d = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  return x * (theta_d / r);
}

bool radtan_grows(const CameraCalibration& camera, double r2) {
  if (r2 > max_tangent_radtan * max_tangent_radtan) return false;
  return 1 + 3 * camera.distortion[0] * r2 + 5 * camera.distortion[1] * r2 * r2 > 0;
}

/// Of a point in C; empty where the model is not valid.
std::optional<Eigen::Vector2d> distorted(const CameraCalibration& camera, const Eigen::Vector3d& p) {
  if (camera.model == DistortionModel::equidistant) {
    const Eigen::Vector2d side = p.head<2>();
    const double theta = std::atan2(side.norm(), p.z());
    if (theta > max_angle_equidistant) return std::nullopt;
    return distort_equidistant(side.norm() < tiny_radius ? Eigen::Vector2d(side / p.z()) : side, theta,
                               camera.distortion);
  }
  if (p.z() <= 0) return std::nullopt;
  const Eigen::Vector2d x = p.head<2>() / p.z();
  const double r2 = x.squaredNorm();
  if (camera.model == DistortionModel::fov)
    return r2 < max_tangent * max_tangent ? std::optional(distort_fov(x, camera.distortion[0])) : std::nullopt;
  return radtan_grows(camera, r2) ? std::optional(distort_radtan(x, camera.distortion)) : std::nullopt;
}

/// Angle from the axis whose distorted radius is r_d; negative where there is none.
double angle_of_fov(double r_d, double w) {
  const double angle = r_d * w;
  return angle < max_angle_back ? std::atan(std::tan(angle) / (2 * std::tan(w / 2))) : -1;
}

double angle_of_equidistant(double r_d, const Eigen::Vector4d& k) {
  double theta = r_d;
  for (int i = 0; i < newton_steps; ++i) {
    const double t2 = theta * theta;
    const double value = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) - r_d;
    const double slope = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
    if (!(slope > 0)) return -1;
    theta -= value / slope;
    if (std::abs(value) < newton_converged) return theta;
  }
  return -1;
}

/// Newton on the plane, the Jacobian by central differences.
std::optional<Eigen::Vector3d> bearing_of_radtan(const CameraCalibration& camera, const Eigen::Vector2d& d) {
  constexpr double h = 1e-6;
  Eigen::Vector2d x = d;
  for (int i = 0; i < newton_steps; ++i) {
    if (x.norm() > max_radius_back_radtan) return std::nullopt;
    const double r2 = x.squaredNorm();
    if (!(1 + 3 * camera.distortion[0] * r2 + 5 * camera.distortion[1] * r2 * r2 > 0)) return std::nullopt;
    const Eigen::Vector2d error = distort_radtan(x, camera.distortion) - d;
    if (error.norm() < newton_converged) return Eigen::Vector3d(x.x(), x.y(), 1).normalized();
    Eigen::Matrix2d J;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = h * Eigen::Vector2d::Unit(axis);
      J.col(axis) =
          (distort_radtan(x + step, camera.distortion) - distort_radtan(x - step, camera.distortion)) / (2 * h);
    }
    x -= J.inverse() * error;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Eigen::Vector2d> project(const CameraCalibration& camera, const Eigen::Vector3d& p_C, double border_px) {
  const std::optional<Eigen::Vector2d> d = distorted(camera, p_C);
  if (!d) return std::nullopt;
  const Eigen::Vector2d pixel(camera.intrinsics[0] * d->x() + camera.intrinsics[2],
                              camera.intrinsics[1] * d->y() + camera.intrinsics[3]);
  return is_inside(camera, pixel, border_px) ? std::optional(pixel) : std::nullopt;
}

bool is_inside(const CameraCalibration& camera, const Eigen::Vector2d& pixel, double border_px) {
  return pixel.x() >= border_px && pixel.x() <= camera.width - 1 - border_px &&  //
         pixel.y() >= border_px && pixel.y() <= camera.height - 1 - border_px;
}

std::optional<Eigen::Vector3d> bearing_of(const CameraCalibration& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d d = (pixel - camera.intrinsics.tail<2>()).cwiseQuotient(camera.intrinsics.head<2>());
  if (camera.model == DistortionModel::radtan) return bearing_of_radtan(camera, d);
  const double r_d = d.norm();
  const bool fov = camera.model == DistortionModel::fov;
  const double theta = fov ? angle_of_fov(r_d, camera.distortion[0]) : angle_of_equidistant(r_d, camera.distortion);
  if (theta < 0 || theta > (fov ? max_angle_back : max_angle_equidistant)) return std::nullopt;
  if (r_d < tiny_radius) return Eigen::Vector3d::UnitZ();
  const Eigen::Vector2d side = d * (std::sin(theta) / r_d);
  return Eigen::Vector3d(side.x(), side.y(), std::cos(theta));
}

}  // namespace host::sim
