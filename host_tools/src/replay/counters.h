// What a core counted, by name.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "recording.h"

namespace host {

using Counters = std::vector<std::pair<std::string, std::uint32_t>>;

/// 0 where there is none of that name.
inline std::uint32_t count_of(const Counters& counters, const char* name) {
  const auto at = std::find_if(counters.begin(), counters.end(), [name](const auto& c) { return c.first == name; });
  return at == counters.end() ? 0 : at->second;
}

Counters difference(Counters now, const Counters& before);

/// Adds the images that the reader set aside (stamps/stray_frames.h): they
/// were offered, and are of no clock of their log. A rig's count once.
void count_strays(const std::vector<Recording>& sessions, Counters* counters);

}  // namespace host
