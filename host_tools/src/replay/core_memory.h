// What the core remembers beside its kept segments, as the host reads it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace host {

/// What condensed segments said, alone with the prior; in the order of the parameters.
struct CoreEpoch {
  int segments = 0;
  unsigned first_session = 0, last_session = 0;
  std::vector<double> value, sigma;
};

/// What was condensed of one session, also of one that a change has outdated.
struct CoreSession : CoreEpoch {
  double temperature_degC = 25;
  int changes = 0;  ///< of the device that were decided before
};

/// Names of SEGCAL_COURSE_*, in the order of their bits.
inline constexpr std::array<const char*, 3> course_names = {"steps", "trend", "temperature"};

/// How the calibration changed over sessions (segcal_course_t).
struct CoreCourse {
  std::vector<std::string> courses;  ///< of course_names: not ruled out; empty: not asked
  int sessions = 0;
  std::array<double, 3> ln_odds{};  ///< of these three; 1: not compared
  /// The one that `rate` is of; empty: decided changes, or none, explain what came
  std::string rate_of;
  unsigned step_session = 0;        ///< of steps: the first one after it, from 0
  std::vector<double> rate, sigma;  ///< per session or degC
};

/// A step of the calibration between what was known and a release
/// that dropped it; steps in the order of the parameters.
struct CoreChange {
  bool open = false;  ///< not decided: no steps
  unsigned before_session = 0, after_session = 0;
  std::int64_t t_ns = 0;  ///< where the segment begins that contradicted first
  std::vector<double> step, sigma;
};

}  // namespace host
