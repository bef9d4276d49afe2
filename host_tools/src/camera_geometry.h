// Pixels to rays on the host, in double. The core has its own models; this one serves the tools before the core.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "calibration_file.h"

namespace host {

/// Undistorted normalised coordinates (x/z, y/z) of a raw pixel; empty where the model has no ray in front of the
/// camera within 85 degrees of the axis, or where the inversion does not converge.
std::optional<Eigen::Vector2d> undistort(const CameraCalibration& camera, const Eigen::Vector2d& pixel);

/// Raw pixel of the normalised coordinates (x/z, y/z), the inverse of undistort().
Eigen::Vector2d distort(const CameraCalibration& camera, const Eigen::Vector2d& normalised);

}  // namespace host
