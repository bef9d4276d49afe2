// Times of a sentence: seconds from the first IMU sample of the recording that holds them.
#pragma once

#include <algorithm>

#include "formatted.h"
#include "recording.h"

namespace host::review {

inline double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

/// "at 31.2 s" of the recording that holds both stamps, or "between 24.0 and 28.2 s"; "in an earlier session", of
/// which there is no recording.
inline std::string when(const std::vector<Recording>& sessions, std::int64_t from_ns, std::int64_t to_ns) {
  std::int64_t zero_ns = 0;
  bool held = false;
  for (const Recording& r : sessions) {
    if (r.imu.samples.empty() || r.imu.samples.front().t_ns > from_ns) continue;
    zero_ns = held ? std::max(zero_ns, r.imu.samples.front().t_ns) : r.imu.samples.front().t_ns;
    held = true;
  }
  if (!held) return "in an earlier session";
  const double from_s = seconds_between(zero_ns, from_ns), to_s = seconds_between(zero_ns, to_ns);
  return to_s - from_s > 1 ? formatted("between %.1f and %.1f s", from_s, to_s) : formatted("at %.1f s", to_s);
}

}  // namespace host::review
