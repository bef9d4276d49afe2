// Landmarks: the points of the world that can be tracked.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "trajectory.h"

namespace host::sim {

/// Distance from the camera at which a landmark can be tracked, m.
struct DepthRange {
  double near = 0.7, far = 6;
};

/// Points on walls, floor, ceiling and objects around the motion between t_begin and t_end, s. Where the motion stays
/// within a few metres they fill one furnished room; otherwise corridors along the way. In G, m.
std::vector<Eigen::Vector3d> make_scene(const Trajectory& truth, double t_begin, double t_end, std::uint64_t seed);

}  // namespace host::sim
