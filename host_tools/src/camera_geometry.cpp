#include "camera_geometry.h"

#include <Eigen/LU>
#include <cmath>

#include "angles.h"

namespace host {
namespace {

using Eigen::Vector2d;
using Eigen::Vector4d;

constexpr double max_angle = 85 * rad_per_deg;
constexpr double tiny = 1e-12;

/// Each model is a radial factor r_d / r, and radtan adds Brown's tangential terms.
Vector2d distort_normalised(DistortionModel model, const Vector4d& d, const Vector2d& m) {
  const double r = m.norm();
  switch (model) {
    case DistortionModel::fov: {
      const double w = d[0];
      if (r < tiny || std::abs(w) < 1e-6) return m;
      return m * (std::atan(2 * r * std::tan(w / 2)) / (w * r));
    }
    case DistortionModel::equidistant: {
      if (r < tiny) return m;
      const double theta = std::atan(r), t2 = theta * theta;
      return m * (theta * (1 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3])))) / r);
    }
    case DistortionModel::radtan: {
      const double r2 = r * r, x = m.x(), y = m.y();
      const double radial = 1 + r2 * (d[0] + r2 * d[1]);
      return {x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x),
              y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y};
    }
  }
  return m;
}

/// Newton with a central-difference Jacobian: the same lines
/// for all models, and fast enough for a tracker's few points.
std::optional<Vector2d> invert(DistortionModel model, const Vector4d& d, const Vector2d& distorted, Vector2d guess) {
  constexpr double step = 1e-6;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Vector2d error = distort_normalised(model, d, guess) - distorted;
    if (error.norm() < 1e-10) return guess;
    Eigen::Matrix2d J;
    for (int axis = 0; axis < 2; ++axis) {
      const Vector2d offset = step * Vector2d::Unit(axis);
      J.col(axis) =
          (distort_normalised(model, d, guess + offset) - distort_normalised(model, d, guess - offset)) / (2 * step);
    }
    if (!(J.determinant() > 1e-3)) return std::nullopt;  // beyond the fold, where the model turns back on itself
    guess -= J.inverse() * error;
  }
  return std::nullopt;
}

/// Where Newton starts: exact for fov, close for equidistant, the distorted point itself for radtan.
Vector2d first_guess(DistortionModel model, const Vector4d& d, const Vector2d& distorted) {
  const double r = distorted.norm();
  if (r < tiny || model == DistortionModel::radtan) return distorted;
  if (model == DistortionModel::equidistant) return distorted * (std::tan(std::min(r, max_angle)) / r);
  const double w = d[0];
  if (std::abs(w) < 1e-6) return distorted;
  return distorted * (std::tan(std::min(r * w, max_angle)) / (2 * std::tan(w / 2) * r));
}

}  // namespace

std::optional<Vector2d> undistort(const CameraCalibration& camera, const Vector2d& pixel) {
  const Vector4d& k = camera.intrinsics;
  const Vector2d distorted((pixel.x() - k[2]) / k[0], (pixel.y() - k[3]) / k[1]);
  if (!distorted.allFinite()) return std::nullopt;
  const auto normalised =
      invert(camera.model, camera.distortion, distorted, first_guess(camera.model, camera.distortion, distorted));
  if (!normalised || normalised->norm() > std::tan(max_angle)) return std::nullopt;
  return normalised;
}

Vector2d distort(const CameraCalibration& camera, const Vector2d& normalised) {
  const Vector2d m = distort_normalised(camera.model, camera.distortion, normalised);
  const Vector4d& k = camera.intrinsics;
  return {k[0] * m.x() + k[2], k[1] * m.y() + k[3]};
}

}  // namespace host
