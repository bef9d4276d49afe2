// What rotation told before anything could be fitted (clock_offset.h): effects that are there; a fit only refines them.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace host::diagnosis {

struct Told {
  std::vector<std::string> effects;
  double line_delay = 0;  ///< where rolling_shutter starts, s/line: odometry does not run without it

  bool has(const std::string& effect) const {
    return std::find(effects.begin(), effects.end(), effect) != effects.end();
  }
};

}  // namespace host::diagnosis
