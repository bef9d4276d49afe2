// A smooth motion fitted to recorded poses, so that real movements can be simulated with exact rates.
#pragma once

#include <cstdint>
#include <filesystem>
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

/// Reads a groundtruth.csv (timestamp [ns], p_xyz [m], q_wxyz, more columns ignored) and fits
/// quintic splines with a knot each `knot_step`, s: 0.1 keeps motion up to about 3 Hz, 0.05
/// up to about 6 Hz. Throws InputError for a malformed file, stamps that do not increase,
/// less than 3 s of poses, or a tilt of 85 degrees away from the attitude in the middle.
FittedTrajectory fit_trajectory(const std::filesystem::path& file, double knot_step);

}  // namespace host::sim
