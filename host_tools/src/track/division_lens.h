// A lens by one number, for tests of correspondences before any calibration is known.
#pragma once

#include <Eigen/Core>

namespace host {

/// The division model (Fitzgibbon, "Simultaneous linear estimation of multiple view geometry and lens distortion", CVPR
/// 2001): a point at r half diagonals from the image's centre is seen along (x, y, 1 + bend r^2). A pinhole has bend
/// 0, a lens of 120 deg some -0.3, a fisheye of 180 deg -1.2. The scale is left to the epipolar geometry.
class DivisionLens {
 public:
  DivisionLens(int width_px, int height_px, double bend);

  Eigen::Vector3d ray(const Eigen::Vector2d& pixel) const;  ///< homogeneous, not of unit length
  /// d ray / d pixel, 1/px.
  Eigen::Matrix<double, 3, 2> ray_by_pixel(const Eigen::Vector2d& pixel) const;
  double half_diagonal_px() const { return half_diagonal_px_; }

 private:
  Eigen::Vector2d centred(const Eigen::Vector2d& pixel) const { return (pixel - centre_px_) / half_diagonal_px_; }

  Eigen::Vector2d centre_px_;
  double half_diagonal_px_, bend_;
};

}  // namespace host
