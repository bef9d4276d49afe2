// The covariance of an IMU link, integrated beside the link.
#pragma once

#include "reference/imu_residual.h"

namespace host::reference {

/// Place of a sensor's scale among the integral's inputs: the gyroscope's axes, then the accelerometer's.
inline int scale_input(int k) { return k < 3 ? 6 + k : 9 + k; }

/// How errors [rotation | velocity | position | b_a | b_g] grow, and what noise is added per second.
struct ErrorModel {
  Eigen::Matrix3d rate_by_bias, force_by_bias;  ///< in I
  LinkMatrix noise = LinkMatrix::Zero();        ///< of b_a and b_g
  Eigen::Vector3d gyro2, accel2;                ///< by axis

  ErrorModel(const CoreModel& model, const LinkNoise& white, const double* inputs, const Eigen::Matrix3d& R_AI);
  /// The white noise of one axis alone.
  ErrorModel of_axis(int k) const;
  /// The derivative of the covariance by time. White noise of the sensors enters as their biases do.
  LinkMatrix slope(const LinkMatrix& P, const Eigen::Matrix3d& R, const Eigen::Vector3d& w,
                   const Eigen::Vector3d& f) const;
};

/// The covariance of the integral and the biases by the same Runge-Kutta method, beside the integral itself.
LinkMatrix covariance(const std::vector<Step>& steps, const Sensor<double>& sensor, const ErrorModel& errors);

}  // namespace host::reference
