// The IMU's scale and misalignment in Kalibr's imu.yaml, and its translation into segcal's convention.
//
// Kalibr: measurement = M C x + b, with x in its body frame and any 3x3 M; C
// is gyroscopes.C_gyro_i, accelerometers.C_accel_i. segcal: w_m = T_g w +
// b_g, a_m = T_a R_AI f + b_a, T upper triangular, I the gyroscope's frame.
#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "calibration_file.h"

namespace host {

/// Reads gyroscopes.{M, C_gyro_i} and accelerometers.{M, C_accel_i}; each missing entry is the identity. Where Kalibr's
/// body frame is not the gyroscope's (its M is lower triangular there), the cameras' R_CI and p_CI are turned into I
/// too. Throws InputError for a malformed matrix or a scale that is not positive.
void read_imu_model(const std::filesystem::path& file, Calibration& calibration);

/// A = T R with T upper triangular, its diagonal positive, and R a rotation. det(A) > 0 is required.
struct ScaleAndRotation {
  Eigen::Matrix3d T;
  Eigen::Matrix3d R;
};
ScaleAndRotation split_scale_and_rotation(const Eigen::Matrix3d& A);

}  // namespace host
