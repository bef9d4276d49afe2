// From a point in the camera's frame to a raw pixel: the simulator's own models, written apart from the core's.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "../calibration_file.h"

namespace host::sim {

/// Raw pixel of a point p_C, m, in the camera's frame. Empty where the point is behind the camera, farther from the
/// axis than the model is valid for (80 degrees; equidistant 100; radtan 60 and only while the distorted radius grows
/// with the true one), or within `border_px` of the image's edge.
std::optional<Eigen::Vector2d> project(const CameraCalibration& camera, const Eigen::Vector3d& p_C, double border_px);
/// At least border_px from the edge; negative: at most so far outside.
bool is_inside(const CameraCalibration& camera, const Eigen::Vector2d& pixel, double border_px);

/// The way back: the unit vector in C that a raw pixel looks along. Empty where the model has none within 88 degrees of
/// the axis (radtan 75, and only while the distorted radius grows with the true one; equidistant 100).
std::optional<Eigen::Vector3d> bearing_of(const CameraCalibration& camera, const Eigen::Vector2d& pixel);

}  // namespace host::sim
