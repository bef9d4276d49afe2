// Order statistics of lists: the one definition that all of the host tools use.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace host {

/// Value below which a share q lies, on the line between the two nearest; not-a-number for an empty list.
inline double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const double place = q * static_cast<double>(values.size() - 1);
  const auto i = static_cast<std::size_t>(place);
  const double share = place - static_cast<double>(i);
  return i + 1 < values.size() ? (1 - share) * values[i] + share * values[i + 1] : values[i];
}

/// The value in the middle, of an even number of them the upper one;
/// the list is not empty. For values that must be one of the list's.
inline double middle_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace host
