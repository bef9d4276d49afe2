// The temperature of the IMU over a recording.
#pragma once

#include <cmath>

namespace host::sim {

/// The effects of temperature are zero here.
constexpr double reference_temperature_degC = 25;

/// Warm-up after switching on: from `begin_degC` towards `end_degC` with one time constant; a straight line would be
/// one with the slow drift of a bias, and a step is none that a sensor shows.
struct WarmUp {
  double begin_degC = reference_temperature_degC, end_degC = 40;
  double time_constant_s = 20;
  double begins_s = 0;  ///< when, on the trajectory's clock

  double at(double t) const {
    const double since = t - begins_s;
    return since <= 0 ? begin_degC : end_degC - (end_degC - begin_degC) * std::exp(-since / time_constant_s);
  }
};

/// Where there is no temperature.
inline WarmUp no_warm_up() { return {reference_temperature_degC, reference_temperature_degC}; }

}  // namespace host::sim
