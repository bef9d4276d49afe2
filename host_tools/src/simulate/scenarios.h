// The motions that can be simulated, each drawn from a seed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trajectory.h"

namespace host::sim {

/// One motion: its name, a line for --help, and its function.
struct Scenario {
  const char* name;
  const char* description;
  /// Samples at t0 + k * step, s, `n` of them.
  std::vector<MotionSample> (*generate)(std::uint64_t seed, double t0, double step, std::size_t n);
};

/// All scenarios, in the order in which --help lists them.
const std::vector<Scenario>& scenarios();

/// The motion of a scenario for times from 0 to `seconds` and
/// 1 s on either side. Throws InputError for an unknown name.
Trajectory make_trajectory(const std::string& scenario, double seconds, std::uint64_t seed);

std::vector<MotionSample> arvr_motion(std::uint64_t seed, double t0, double step, std::size_t n);
std::vector<MotionSample> nav_motion(std::uint64_t seed, double t0, double step, std::size_t n);
std::vector<MotionSample> rich_motion(std::uint64_t seed, double t0, double step, std::size_t n);
std::vector<MotionSample> still_motion(std::uint64_t seed, double t0, double step, std::size_t n);
std::vector<MotionSample> rotation_motion(std::uint64_t seed, double t0, double step, std::size_t n);
std::vector<MotionSample> line_motion(std::uint64_t seed, double t0, double step, std::size_t n);
std::vector<MotionSample> planar_motion(std::uint64_t seed, double t0, double step, std::size_t n);

}  // namespace host::sim
