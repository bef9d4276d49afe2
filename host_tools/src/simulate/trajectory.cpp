#include "trajectory.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace host::sim {
namespace {

/// Angular rate in the frame that Rz Ry Rx turns, from the rates of the three angles.
Eigen::Vector3d rate_from_angles(const Eigen::Vector3d& angles, const Eigen::Vector3d& rates) {
  const double sin_roll = std::sin(angles.x()), cos_roll = std::cos(angles.x());
  const double sin_pitch = std::sin(angles.y()), cos_pitch = std::cos(angles.y());
  return {rates.x() - rates.z() * sin_pitch,                        //
          rates.y() * cos_roll + rates.z() * cos_pitch * sin_roll,  //
          -rates.y() * sin_roll + rates.z() * cos_pitch * cos_roll};
}

Spline spline_of(double t0, double step, const std::vector<MotionSample>& samples,
                 Eigen::Vector3d MotionSample::*member) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(samples.size());
  for (const MotionSample& sample : samples) points.push_back(sample.*member);
  return Spline(t0, step, std::move(points));
}

}  // namespace

Eigen::Matrix3d rotation_from_angles(const Eigen::Vector3d& roll_pitch_yaw) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(roll_pitch_yaw.z(), Vector3d::UnitZ()) * AngleAxisd(roll_pitch_yaw.y(), Vector3d::UnitY()) *
          AngleAxisd(roll_pitch_yaw.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Vector3d angles_from_rotation(const Eigen::Matrix3d& R) {
  const double pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

Trajectory::Trajectory(Spline position, Spline q_vector, Spline q_scalar)
    : position_(std::move(position)),
      q_vector_(std::move(q_vector)),
      q_scalar_(std::move(q_scalar)),
      has_quaternion_(true) {}

Trajectory::Trajectory(double t0, double step, const std::vector<MotionSample>& samples)
    : position_(spline_of(t0, step, samples, &MotionSample::position)),
      angles_(spline_of(t0, step, samples, &MotionSample::roll_pitch_yaw)) {}

/// As the splines have it, not of unit length.
Eigen::Quaterniond Trajectory::quaternion(double t, int order) const {
  const Eigen::Vector3d v = q_vector_.evaluate(t, order);
  return {q_scalar_.evaluate(t, order).x(), v.x(), v.y(), v.z()};
}

BodyState Trajectory::at(double t) const {
  BodyState state;
  state.p_GI = position_.evaluate(t, 0);
  state.v_GI = position_.evaluate(t, 1);
  state.a_GI = position_.evaluate(t, 2);
  if (has_quaternion_) {
    // With q = Q / |Q|: w = 2 vec(q* dq/dt), to which the part of dq/dt along Q adds nothing.
    const Eigen::Quaterniond Q = quaternion(t, 0);
    state.R_GI = Q.normalized().toRotationMatrix();
    state.w_GI = 2 * (Q.conjugate() * quaternion(t, 1)).vec() / Q.squaredNorm();
    return state;
  }
  const Eigen::Vector3d angles = angles_.evaluate(t, 0);
  state.R_GI = rotation_from_angles(angles);
  state.w_GI = rate_from_angles(angles, angles_.evaluate(t, 1));
  return state;
}

}  // namespace host::sim
