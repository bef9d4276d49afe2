// The catalogue of effects (docs/diagnosis.md, section 4): names, parameters, units, how large they may be, what they
// look like and what they are confounded with. An effect's parameters are its terms, in this order.
#pragma once

#include "sensors/effect_terms.h"

namespace SEGCAL_NS {

constexpr int kEffects = 12;
constexpr int kMostTermsOfEffect = 9;

struct EffectEntry {
  const char* name;
  std::int32_t n;  ///< parameters
  const char* parameter[kMostTermsOfEffect];
  const char* unit;
  double prior_sigma;  ///< of each parameter about zero
  const char* looks_like;
  const char* confounded;  ///< with what, on which motion
};

inline const EffectEntry& effect_entry(int e) {
  static constexpr EffectEntry kCatalogue[kEffects] = {
      // clang-format off
      {"time_offset", 1, {"t_d"}, "s", 0.02,
       "image residuals along the image motion, the same for all rows",
       "p_CI along the direction of motion at constant speed on a straight line; gyro_lag where only rotation is seen"},
      {"rolling_shutter", 1, {"line_delay"}, "s/row", 5e-5,
       "image residuals along the image motion, growing with the row's distance from the middle",
       "fx against fy and cam.r_CI at one constant rate of rotation"},
      {"radial_residual", 1, {"k"}, "-", 0.05,
       "image residuals towards or away from the principal point, largest in the corners",
       "the model's own radial coefficients and the focal length, where points stay in the middle of the image"},
      {"tangential_residual", 2, {"p1", "p2"}, "-", 0.01,
       "image residuals of one sign on one half of the image's border",
       "cx, cy and r_CI, where points stay in the middle"},
      {"gyro_g_sensitivity", 9, {"xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"}, "rad s/m", 2e-3,
       "rotation residuals that follow the specific force",
       "the gyroscope's bias, unless the device is tilted or shaken"},
      {"gyro_nonlinearity", 3, {"x", "y", "z"}, "s/rad", 5e-3,
       "rotation residuals at high rates, of the rate's own sign", "gyro.s at one rate"},
      {"accel_nonlinearity", 3, {"x", "y", "z"}, "s^2/m", 1e-3,
       "velocity residuals that grow with the square of the force", "accel bias and accel.s at one attitude"},
      {"gyro_temperature", 3, {"x", "y", "z"}, "rad/s/degC", 1e-3,
       "the gyroscope's bias follows the temperature",
       "the bias walk, within one segment and without a change of temperature"},
      {"accel_temperature", 3, {"x", "y", "z"}, "m/s^2/degC", 1e-2,
       "the accelerometer's bias follows the temperature",
       "the bias walk, within one segment and without a change of temperature"},
      {"gyro_lag", 1, {"tau"}, "s", 0.01,
       "rotation residuals that follow the angular acceleration",
       "time_offset, unless the device is accelerated as well: the camera and the gyroscope alone cannot tell "
       "which is late"},
      {"accel_axis_offset", 6, {"yx", "yy", "yz", "zx", "zy", "zz"}, "m", 0.02,
       "velocity residuals that follow the angular acceleration and the square of the rate",
       "p_CI, where only one axis is turned"},
      {"camera_temperature", 6, {"rx", "ry", "rz", "f", "cx", "cy"}, "1/degC", 2e-4,
       "the camera's rotation, f and c (in focal lengths) follow the temperature", "r_CI, f, c at one temperature"}};
  // clang-format on
  return kCatalogue[e];
}

/// Term i of effect e.
inline Term effect_term(int e, int i) {
  constexpr auto byte = [](int v) { return static_cast<std::uint8_t>(v); };
  constexpr auto axis = [](TermKind first, int k) { return static_cast<TermKind>(static_cast<int>(first) + k); };
  constexpr auto signal = [](Signal first, int k) { return static_cast<std::uint8_t>(static_cast<int>(first) + k); };
  switch (e) {
    case 0: return kTimeOffsetTerm;
    case 1: return kLineDelayTerm;
    case 2: return {TermKind::radial, 0, 0, 0};
    case 3: return {axis(TermKind::tangential_1, i), 0, 0, 0};
    case 4: return {axis(TermKind::gyro_x, i / 3), signal(Signal::fx, i % 3), 0, 0};
    case 5: return {axis(TermKind::gyro_x, i), signal(Signal::wx, i), signal(Signal::abs_wx, i), 0};
    case 6: return {axis(TermKind::accel_x, i), signal(Signal::fx, i), signal(Signal::fx, i), 0};
    case 7: return {axis(TermKind::gyro_x, i), signal(Signal::warmth, 0), 0, 0};
    case 8: return {axis(TermKind::accel_x, i), signal(Signal::warmth, 0), 0, 0};
    case 9: return {TermKind::gyro_lag, 0, 0, 0};
    case 10: return {TermKind::axis_offset, byte(i), 0, 0};
    default: return {TermKind::camera_warmth, byte(i), 0, 0};
  }
}

/// Where a term stands in the catalogue; false if it does not.
inline bool find_effect(const Term& t, int* effect, int* parameter) {
  for (int e = 0; e < kEffects; ++e) {
    for (int i = 0; i < effect_entry(e).n; ++i) {
      if (!(effect_term(e, i) == t)) continue;
      *effect = e;
      *parameter = i;
      return true;
    }
  }
  return false;
}

/// What a signal of a hand-held device is about, in its unit.
inline double typical_signal(Signal s) {
  constexpr double kTypical[kSignals] = {1, 1, 1, 1, 1, 1, 1, 1, 10, 10, 10, 10, 10, 10, 10, 60, 1, 1, 10, 10, 10};
  return kTypical[static_cast<int>(s)];
}

/// Prior sigma: the catalogue's, or so much that the term is worth
/// 0.05 rad/s, 0.5 m/s^2 or a hundredth of the focal length.
inline double term_prior_sigma(const Term& t) {
  int effect, parameter;
  if (find_effect(t, &effect, &parameter)) return effect_entry(effect).prior_sigma;
  if (t.of_image()) return 0.01;
  return (t.of_gyro() ? 0.05 : 0.5) /
         (typical_signal(static_cast<Signal>(t.a)) * typical_signal(static_cast<Signal>(t.b)));
}

}  // namespace SEGCAL_NS
