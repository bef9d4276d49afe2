// Where a simulated motion comes from, and when it is simulated.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "simulate.h"
#include "trajectory_fit.h"

namespace host::sim {

/// Times in s on the trajectory's clock.
struct Session {
  Trajectory trajectory;
  std::int64_t time_zero_ns = 0;
  double first_frame = 0, last_frame = 0;
  std::vector<Hole> holes;

  std::int64_t stamp(double t) const { return time_zero_ns + std::llround(t * 1e9); }
  /// The time that a rounded stamp really means, so that stamps and values agree to the last digit.
  double time_of(std::int64_t t_ns) const { return static_cast<double>(t_ns - time_zero_ns) * 1e-9; }
  bool in_hole(double t) const;
};

/// A scenario, recorded poses, or a recording's twin. Throws InputError where poses cannot be followed.
Session session_of(const SimulationOptions& options);

}  // namespace host::sim
