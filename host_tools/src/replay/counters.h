// What a core counted, by name.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace host {

using Counters = std::vector<std::pair<std::string, std::uint32_t>>;

/// 0 where there is none of that name.
inline std::uint32_t count_of(const Counters& counters, const char* name) {
  const auto at = std::find_if(counters.begin(), counters.end(), [name](const auto& c) { return c.first == name; });
  return at == counters.end() ? 0 : at->second;
}

}  // namespace host
