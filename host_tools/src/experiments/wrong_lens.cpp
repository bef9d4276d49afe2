#include "experiments/wrong_lens.h"

#include <cmath>

#include "camera_geometry.h"

namespace host::experiments {
namespace {

constexpr int steps = 12;  // of the grid over the image
constexpr double least_w = 0.05, most_w = 1.5;
constexpr int rounds = 60;  // of golden section: the interval shrinks to 1e-12

/// With the best focal lengths for this w.
CameraCalibration with_w(const CameraCalibration& camera, double w) {
  CameraCalibration out = camera;
  out.model = DistortionModel::fov;
  out.distortion = {w, 0, 0, 0};
  out.intrinsics = {1, 1, 0, 0};
  Eigen::Vector2d products = Eigen::Vector2d::Zero(), squares = Eigen::Vector2d::Zero();
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      const Eigen::Vector2d pixel(i * camera.width / double(steps), j * camera.height / double(steps));
      const auto ray = undistort(camera, pixel);
      if (!ray) continue;
      const Eigen::Vector2d d = distort(out, *ray);
      products += d.cwiseProduct(pixel - camera.intrinsics.tail<2>());
      squares += d.cwiseAbs2();
    }
  }
  out.intrinsics << products.cwiseQuotient(squares), camera.intrinsics.tail<2>();
  return out;
}

}  // namespace

double lens_difference(const CameraCalibration& a, const CameraCalibration& b) {
  double sum = 0;
  int n = 0;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      const Eigen::Vector2d pixel(i * b.width / double(steps), j * b.height / double(steps));
      const auto ray = undistort(b, pixel);
      if (!ray) continue;
      sum += (distort(a, *ray) - pixel).squaredNorm();
      ++n;
    }
  }
  return std::sqrt(sum / n);
}

CameraCalibration as_fov(const CameraCalibration& camera) {
  const double golden = 0.5 * (std::sqrt(5.0) - 1);
  double low = least_w, high = most_w;
  for (int round = 0; round < rounds; ++round) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    if (lens_difference(with_w(camera, a), camera) < lens_difference(with_w(camera, b), camera)) {
      high = b;
    } else {
      low = a;
    }
  }
  return with_w(camera, 0.5 * (low + high));
}

}  // namespace host::experiments
