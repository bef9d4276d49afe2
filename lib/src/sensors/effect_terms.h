// Effects as sums of terms (docs/diagnosis.md, section 4): one term is one number c, one column of theta behind the 15
// of the IMU. Catalogue effects (effect_catalogue.h) and terms of a dictionary are the same thing here.
//
// A term of the IMU adds c phi to the reading, after T_g and T_a R_AI and before
// the bias; phi is a sum of up to three products of two signals. A term of the
// camera moves the time at which a line of the image was exposed, the distorted point, or the camera with temperature.
#pragma once

#include <cstdint>

#include "sensors/inertial_state.h"

namespace SEGCAL_NS {

constexpr int kMaxEffectColumns = SEGCAL_MAX_EFFECT_COLUMNS;  ///< of one elimination: estimated terms and candidates
constexpr int kMaxEffectEstimates = SEGCAL_MAX_EFFECT_ESTIMATES;  ///< terms in theta
static_assert(kMaxEffectEstimates <= kMaxEffectColumns, "every estimated term needs a column");

// clang-format off
enum class TermKind : std::uint8_t {
  gyro_x, gyro_y, gyro_z, accel_x, accel_y, accel_z,  ///< product of the signals a and b, added to this axis
  gyro_lag,                ///< first-order lag of all three axes: -d w_m / dt
  axis_offset,             ///< a: 0..5, the entries yx yy yz zx zy zz
  camera_time,             ///< seconds; a = 0: the same for all rows; a = 1: per line beyond the middle one
  radial, tangential_1, tangential_2,  ///< d |d|^2; Brown's two
  image_u, image_v,        ///< x^a y^b row^c, added to the distorted point d; row: -1 at the top, 1 at the bottom
  camera_warmth            ///< a: 0..5, per degC: r_CI x y z, f, cx, cy (warm_camera.h)
};
// clang-format on

/// Signals that a term of the IMU may use. Rates and forces are corrected readings: w and dw/dt in I; f in I for a term
/// of the gyroscope, in A for one of the accelerometer.
// clang-format off
enum class Signal : std::uint8_t {
  one, wx, wy, wz, abs_wx, abs_wy, abs_wz, abs_w, fx, fy, fz, dwx, dwy, dwz,
  warmth,                  ///< degC above 25
  time,                    ///< s since the device's first sample
  cos_heading, sin_heading,  ///< of the direction in which I's x axis points in the horizontal plane, from G's x axis
  slope_x, slope_y, slope_z,  ///< d w_m / dt as measured: what a lag is undone with
  count
};
// clang-format on
constexpr int kSignals = static_cast<int>(Signal::count);
constexpr int kNamedSignals = static_cast<int>(Signal::slope_x);  ///< those that a dictionary may name

/// Which term; four bytes, compared as a whole.
struct Term {
  TermKind kind;
  std::uint8_t a, b, c;

  bool of_gyro() const { return kind <= TermKind::gyro_z || kind == TermKind::gyro_lag; }
  bool of_imu() const { return kind <= TermKind::axis_offset; }
  bool of_time() const { return kind == TermKind::camera_time; }
  bool of_image() const { return kind > TermKind::camera_time && kind < TermKind::camera_warmth; }
  bool of_warm_camera() const { return kind == TermKind::camera_warmth; }
};
inline bool operator==(const Term& x, const Term& y) {
  return x.kind == y.kind && x.a == y.a && x.b == y.b && x.c == y.c;
}

/// The terms that are part of theta, and their values.
template <class S>
struct EffectTerms {
  std::int32_t n = 0;
  Term term[kMaxEffectEstimates + 1];
  S value[kMaxEffectEstimates + 1];
  std::int64_t time_zero_ns = 0;  ///< of Signal::time

  /// Without capacity the compiler sees that there is nothing to do.
  int count() const { return kMaxEffectEstimates == 0 ? 0 : n; }
  void add(const Term& t, S v) {
    term[n] = t;
    value[n++] = v;
  }
  int place_of(const Term& t) const {
    int i = count() - 1;
    while (i >= 0 && !(term[i] == t)) --i;
    return i;
  }
  S value_of(const Term& t) const {
    const int i = place_of(t);
    return i < 0 ? S(0) : value[i];
  }
  bool any_of_imu() const {
    return any([](const Term& t) { return t.of_imu(); });
  }
  bool any_of_time() const {
    return any([](const Term& t) { return t.of_time(); });
  }
  bool any_of_image() const {
    return any([](const Term& t) { return t.of_image(); });
  }
  bool any_of_warm_camera() const {
    return any([](const Term& t) { return t.of_warm_camera(); });
  }

 private:
  template <class Is>
  bool any(Is is) const {
    for (int i = 0; i < count(); ++i) {
      if (is(term[i])) return true;
    }
    return false;
  }
};

/// Terms that are not part of theta, only asked for: their value is zero.
struct CandidateTerms {
  std::int32_t n = 0;
  Term term[kMaxEffectColumns + 1];

  int count() const { return kMaxEffectColumns == 0 ? 0 : n; }
};

constexpr Term kTimeOffsetTerm{TermKind::camera_time, 0, 0, 0};
constexpr Term kLineDelayTerm{TermKind::camera_time, 1, 0, 0};

}  // namespace SEGCAL_NS
