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

Trajectory::Trajectory(Spline position, Spline angles, const Eigen::Matrix3d& R_reference)
    : position_(std::move(position)), angles_(std::move(angles)), R_reference_(R_reference) {}

Trajectory::Trajectory(double t0, double step, const std::vector<MotionSample>& samples)
    : position_(spline_of(t0, step, samples, &MotionSample::position)),
      angles_(spline_of(t0, step, samples, &MotionSample::roll_pitch_yaw)) {}

BodyState Trajectory::at(double t) const {
  const Eigen::Vector3d angles = angles_.evaluate(t, 0);
  BodyState state;
  state.R_GI = rotation_from_angles(angles) * R_reference_;
  state.p_GI = position_.evaluate(t, 0);
  state.v_GI = position_.evaluate(t, 1);
  state.a_GI = position_.evaluate(t, 2);
  state.w_GI = R_reference_.transpose() * rate_from_angles(angles, angles_.evaluate(t, 1));
  return state;
}

}  // namespace host::sim
