// The temperature of the IMU over a recording.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace host::sim {

/// The effects of temperature are zero here.
constexpr double reference_temperature_degC = 25;

/// Warm-up after switching on: from `begin_degC` towards `end_degC` with one time constant; a straight line would be
/// one with the slow drift of a bias, and a step is none that a sensor shows.
struct WarmUp {
  double begin_degC = reference_temperature_degC, end_degC = 40;
  double time_constant_s = 20;
  double begins_s = 0;                                   ///< when, on the trajectory's clock
  std::vector<std::pair<double, double>> measured = {};  ///< (s, degC) in order of time: taken instead of all of these

  double at(double t) const {
    if (!measured.empty()) return between(t);
    const double since = t - begins_s;
    return since <= 0 ? begin_degC : end_degC - (end_degC - begin_degC) * std::exp(-since / time_constant_s);
  }

 private:
  double between(double t) const {
    const auto next = std::lower_bound(measured.begin(), measured.end(), std::pair<double, double>(t, -1e9));
    if (next == measured.begin() || next == measured.end())
      return (next == measured.end() ? measured.back() : *next).second;
    const auto before = next - 1;
    return before->second + (next->second - before->second) * (t - before->first) / (next->first - before->first);
  }
};

/// Where there is no temperature.
inline WarmUp no_warm_up() { return {reference_temperature_degC, reference_temperature_degC, 20, 0, {}}; }

}  // namespace host::sim
