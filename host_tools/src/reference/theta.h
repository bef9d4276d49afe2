// Theta as a list of numbers, in the order of parameter_names(): differences, what is printed of it, and units.
#pragma once

#include <string>

#include "reference/problem.h"

namespace host::reference {

/// Parameters of a camera: 6 of its place, 4, and the lens.
int camera_parameters(const CameraCalibration& camera);
/// Of the lens alone: 1 or 4.
int lens_parameters(const CameraCalibration& camera);

/// From one calibration to another, numbers that can be compared with sigmas: rotations as rotation vectors of b a'.
Eigen::VectorXd theta_step(const Calibration& from, const Calibration& to);

/// Parameter values as printed: rotations as rotation vectors.
Eigen::VectorXd printed_values(const Calibration& theta);

/// Sigmas of the printed values. `covariance`: rotations as small turns Exp(d) R.
Eigen::VectorXd printed_sigmas(const Calibration& theta, const Eigen::MatrixXd& covariance);

/// rad, m, px or -, by a parameter's name.
std::string unit_of(const std::string& name);

}  // namespace host::reference
