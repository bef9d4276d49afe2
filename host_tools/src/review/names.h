// Lists of names in a sentence.
#pragma once

#include <string>
#include <vector>

namespace host::review {

/// "a", "a and b", "a, b and c", "a, b, c and 4 more".
inline std::string names_of(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 3;
  std::string out;
  for (std::size_t i = 0; i < names.size() && i < kMost; ++i) {
    const bool last = i + 1 == names.size();
    out += (i == 0 ? "" : last ? " and " : ", ") + names[i];
  }
  if (names.size() > kMost) out += " and " + std::to_string(names.size() - kMost) + " more";
  return out;
}

}  // namespace host::review
