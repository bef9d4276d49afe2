// Trajectories as lists of stamped poses, from the files that tools exchange.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "replay/core.h"

namespace host {

struct Pose {
  std::int64_t t_ns = 0;
  Eigen::Vector3d p_GI{0, 0, 0};                             ///< m
  Eigen::Quaterniond q_GI = Eigen::Quaterniond::Identity();  ///< rotates I into G
};
using Poses = std::vector<Pose>;  ///< in order of time, no stamp twice

/// "t [s] x y z [m] qx qy qz qw", as `segcal replay` and evo write it. Throws InputError: missing file, another number
/// of columns, a quaternion that is not of unit length to 1 %, stamps that do not increase.
Poses read_tum(const std::filesystem::path& file);

/// A TUM file, or EuRoC's ASL ground truth (.csv: stamp in ns, position, quaternion w first). Throws InputError.
Poses read_poses(const std::filesystem::path& file);

Poses poses_of(const std::vector<CoreState>& trajectory);
Poses poses_of(const std::vector<TruthPose>& truth);

/// The pose at a stamp, between its neighbours (position linear, attitude along the shortest turn). False before the
/// first pose, after the last, and inside a gap of more than `largest_gap_s`.
bool pose_at(const Poses& poses, std::int64_t t_ns, double largest_gap_s, Pose* out);

}  // namespace host
