// A smooth motion fitted to recorded poses, so that real movements can be simulated with exact rates.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "trajectory.h"

namespace host::sim {

/// Part of a recording without poses, s since the first pose.
struct Hole {
  double begin, end;
};

struct FittedTrajectory {
  Trajectory trajectory;  ///< times in s since `first_pose_ns`
  std::int64_t first_pose_ns = 0;
  std::vector<Hole> holes;    ///< longer than 0.1 s; the fit bridges them smoothly, which is a guess
  double position_rms_m = 0;  ///< of poses against fit
  double rotation_rms_rad = 0;
};

/// Poses of the IMU, in order of time.
struct PoseSeries {
  std::int64_t first_ns = 0;
  std::vector<double> t;  ///< s since the first
  std::vector<Eigen::Vector3d> p_GI;
  std::vector<Eigen::Matrix3d> R_GI;
};

/// Least squares of the values, and a very small weight on third differences that bridges holes; a knot each `step`, s,
/// from t = 0 on.
Spline fit_spline(const std::vector<double>& t, const std::vector<Eigen::Vector3d>& values, double step);

/// Fits quintic splines with a knot each `knot_step`, s: 0.1 keeps motion up to about 3 Hz, 0.05 up to about 6 Hz.
/// `of`: where the poses are from, for messages. Throws InputError for less than 3 s of poses.
FittedTrajectory fit_trajectory(const PoseSeries& poses, const std::string& of, double knot_step);

/// Reads a groundtruth.csv (timestamp [ns], p_xyz [m], q_wxyz, more columns ignored) and fits
/// them. Throws InputError for a malformed file or stamps that do not increase, too.
FittedTrajectory fit_trajectory(const std::filesystem::path& file, double knot_step);

}  // namespace host::sim
