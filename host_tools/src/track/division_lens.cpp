#include "division_lens.h"

#include <cmath>

namespace host {

DivisionLens::DivisionLens(int width_px, int height_px, double bend)
    : centre_px_(0.5 * (width_px - 1), 0.5 * (height_px - 1)),
      half_diagonal_px_(0.5 * std::hypot(width_px, height_px)),
      bend_(bend) {}

Eigen::Vector3d DivisionLens::ray(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d xy = centred(pixel);
  return {xy.x(), xy.y(), 1 + bend_ * xy.squaredNorm()};
}

Eigen::Matrix<double, 3, 2> DivisionLens::ray_by_pixel(const Eigen::Vector2d& pixel) const {
  Eigen::Matrix<double, 3, 2> out;
  out << Eigen::Matrix2d::Identity(), 2 * bend_ * centred(pixel).transpose();
  return out / half_diagonal_px_;
}

}  // namespace host
