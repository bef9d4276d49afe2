// The true motion: position and attitude as smooth functions of time, with exact rates and accelerations.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "spline.h"

namespace host::sim {

/// State of the IMU frame I in the gravity-aligned frame G (z up).
struct BodyState {
  Eigen::Matrix3d R_GI = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_GI = Eigen::Vector3d::Zero();  ///< m
  Eigen::Vector3d v_GI = Eigen::Vector3d::Zero();  ///< m/s, in G
  Eigen::Vector3d a_GI = Eigen::Vector3d::Zero();  ///< m/s^2, in G, gravity not included
  Eigen::Vector3d w_GI = Eigen::Vector3d::Zero();  ///< rad/s, angular rate of I against G, in I
};

/// One sample of a motion, before it is made smooth.
struct MotionSample {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();        ///< m, in G
  Eigen::Vector3d roll_pitch_yaw = Eigen::Vector3d::Zero();  ///< rad; R = Rz(yaw) Ry(pitch) Rx(roll)
};

/// R_GI(t) = Rz(yaw) Ry(pitch) Rx(roll) in scenarios: the map from angles to attitude and rate is smooth everywhere,
/// and only the way back would be singular. Where a motion was recorded, R_GI(t) is that of a quaternion whose four
/// numbers are splines, q / |q|: no attitude is singular.
class Trajectory {
 public:
  Trajectory() = default;
  /// `q_scalar`: w in the first of its three numbers.
  Trajectory(Spline position, Spline q_vector, Spline q_scalar);
  /// Samples at t0 + k * step, s.
  Trajectory(double t0, double step, const std::vector<MotionSample>& samples);

  /// Times outside [first_time, last_time] are clamped.
  BodyState at(double t) const;
  double first_time() const { return position_.first_time(); }
  double last_time() const { return position_.last_time(); }

 private:
  Eigen::Quaterniond quaternion(double t, int order) const;

  Spline position_, angles_, q_vector_, q_scalar_;
  bool has_quaternion_ = false;
};

/// Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Matrix3d rotation_from_angles(const Eigen::Vector3d& roll_pitch_yaw);
/// The inverse, pitch in [-pi/2, pi/2].
Eigen::Vector3d angles_from_rotation(const Eigen::Matrix3d& R);

}  // namespace host::sim
