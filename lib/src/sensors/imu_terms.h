// What the terms of the IMU add to a reading: sums of products
// of two signals, and how the signals come from the samples.
#pragma once

#include "math/elementary.h"
#include "sensors/effect_terms.h"

namespace SEGCAL_NS {

/// sign a b, added to one axis: 0..2 of the gyroscope, 3..5 of the accelerometer.
struct Product {
  std::uint8_t axis;
  std::int8_t sign;
  Signal a, b;
};
constexpr int kMaxProducts = 3;

/// Writes a term's products; returns how many there are.
inline int products_of(const Term& t, Product* out) {
  constexpr Signal one = Signal::one;
  if (t.kind <= TermKind::accel_z) {
    out[0] = {static_cast<std::uint8_t>(t.kind), 1, static_cast<Signal>(t.a), static_cast<Signal>(t.b)};
    return 1;
  }
  if (t.kind == TermKind::gyro_lag) {
    out[0] = {0, -1, Signal::slope_x, one};
    out[1] = {1, -1, Signal::slope_y, one};
    out[2] = {2, -1, Signal::slope_z, one};
    return 3;
  }
  // dw/dt x r + w (w . r) - r w.w, its y for the y accelerometer, its z for the z accelerometer.
  constexpr Product kOffset[6][2] = {{{4, 1, Signal::dwz, one}, {4, 1, Signal::wx, Signal::wy}},
                                     {{4, -1, Signal::wx, Signal::wx}, {4, -1, Signal::wz, Signal::wz}},
                                     {{4, -1, Signal::dwx, one}, {4, 1, Signal::wy, Signal::wz}},
                                     {{5, -1, Signal::dwy, one}, {5, 1, Signal::wx, Signal::wz}},
                                     {{5, 1, Signal::dwx, one}, {5, 1, Signal::wy, Signal::wz}},
                                     {{5, -1, Signal::wx, Signal::wx}, {5, -1, Signal::wy, Signal::wy}}};
  for (int i = 0; i < 2; ++i) out[i] = kOffset[t.a % 6][i];
  return 2;
}

/// What a reading has beside it that terms may need.
template <class S>
struct Surroundings {
  Vec3<S> slope = Vec3<S>::Zero();    ///< d w_m / dt, rad/s^2
  S warmth = S(0), time = S(0);       ///< degC above 25; s since the device's first sample
  Vec2<S> heading = Vec2<S>::Zero();  ///< its cosine and sine
};

template <class S>
Surroundings<S> interpolate(const Surroundings<S>& a, const Surroundings<S>& b, S u) {
  return {a.slope + u * (b.slope - a.slope), a.warmth + u * (b.warmth - a.warmth), a.time + u * (b.time - a.time),
          a.heading + u * (b.heading - a.heading)};
}

/// All signals at one moment; the forces twice, in I and in A.
template <class S>
class SignalValues {
 public:
  /// `T_g_inv` takes the measured slope into I.
  SignalValues(const Vec3<S>& w_I, const Vec3<S>& f_I, const Vec3<S>& f_A, const Mat3<S>& T_g_inv,
               const Surroundings<S>& s) {
    const Vec3<S> dw = T_g_inv * s.slope;
    value_[0] = S(1);
    for (int i = 0; i < 3; ++i) {
      value_[int(Signal::wx) + i] = w_I(i);
      value_[int(Signal::abs_wx) + i] = absolute(w_I(i));
      value_[int(Signal::fx) + i] = f_I(i);
      value_[int(Signal::dwx) + i] = dw(i);
      value_[int(Signal::slope_x) + i] = s.slope(i);
      f_A_[i] = f_A(i);
    }
    value_[int(Signal::abs_w)] = square_root(w_I.squaredNorm());
    value_[int(Signal::warmth)] = s.warmth;
    value_[int(Signal::time)] = s.time;
    value_[int(Signal::cos_heading)] = s.heading(0);
    value_[int(Signal::sin_heading)] = s.heading(1);
  }

  S of(const Product& p) const { return S(p.sign) * factor(p.a, p.axis) * factor(p.b, p.axis); }

  /// Adds c phi to (gyro, accel).
  void add(const Term& t, S c, Vec3<S>* gyro, Vec3<S>* accel) const {
    Product product[kMaxProducts];
    const int n = products_of(t, product);
    for (int i = 0; i < n; ++i) {
      const S v = c * of(product[i]);
      (product[i].axis < 3 ? (*gyro)(product[i].axis) : (*accel)(product[i].axis - 3)) += v;
    }
  }

 private:
  S factor(Signal s, int axis) const {
    const int force = int(s) - int(Signal::fx);
    return axis >= 3 && force >= 0 && force < 3 ? f_A_[force] : value_[int(s)];
  }
  S value_[kSignals], f_A_[3];
};

/// Derivatives of an integral (imu_integral.h) by terms, one at a time, in memory that the caller lends: they go
/// through the same recursion as the biases and the scales. A term moves either the rate or the force.
template <class S>
struct ImuTermColumns {
  std::int32_t n = 0;
  Term term[kMaxEffectColumns + 1];
  Vec3<S> J_R[kMaxEffectColumns + 1], J_v[kMaxEffectColumns + 1], J_p[kMaxEffectColumns + 1];
  Vec3<S> input[kMaxEffectColumns + 1];  ///< d w_I or d f_I by c at the current reading
  Vec3<S> D[kMaxEffectColumns + 1];      ///< d (dR f_I) by c there
  S link[kMaxEffectColumns + 1][15];     ///< of a link's residual (imu_link.h), whitened

  int count() const { return kMaxEffectColumns == 0 ? 0 : n; }
};

}  // namespace SEGCAL_NS
