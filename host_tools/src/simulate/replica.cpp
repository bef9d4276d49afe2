#include "replica.h"

#include <algorithm>

namespace host::sim {

double latest(const std::vector<std::pair<double, double>>& values, double t) {
  const auto after = std::upper_bound(values.begin(), values.end(), std::pair<double, double>(t, 1e9));
  return (after == values.begin() ? *after : *(after - 1)).second;
}

}  // namespace host::sim
