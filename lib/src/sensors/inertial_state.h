// Quantities of the inertial model: keyframe states, noise densities, readings (docs/design.md, section 2).
#pragma once

#include "math/so3.h"

namespace SEGCAL_NS {

/// State of a keyframe. Error columns: [theta 3 | p 3 | v 3 | b_a 3 | b_g 3], R <- R Exp(theta), the rest added.
template <class S>
struct State {
  Mat3<S> R_GI = Mat3<S>::Identity();
  Vec3<S> p_GI = Vec3<S>::Zero();  ///< m
  Vec3<S> v_GI = Vec3<S>::Zero();  ///< m/s
  Vec3<S> b_a = Vec3<S>::Zero();   ///< m/s^2
  Vec3<S> b_g = Vec3<S>::Zero();   ///< rad/s

  void add(const S* d) {
    R_GI = renormalised<S>(R_GI * so3_exp<S>(Vec3<S>(d[0], d[1], d[2])));
    p_GI += Vec3<S>(d[3], d[4], d[5]);
    v_GI += Vec3<S>(d[6], d[7], d[8]);
    b_a += Vec3<S>(d[9], d[10], d[11]);
    b_g += Vec3<S>(d[12], d[13], d[14]);
  }
};
constexpr int kStateColumns = 15;
constexpr int kPoseColumns = 6;  ///< the first six: theta and p

/// Continuous-time noise densities.
template <class S>
struct ImuNoise {
  S gyro = S(1.7e-4);      ///< rad/s/sqrt(Hz)
  S gyro_walk = S(2e-5);   ///< rad/s^2/sqrt(Hz)
  S accel = S(2e-3);       ///< m/s^2/sqrt(Hz)
  S accel_walk = S(3e-4);  ///< m/s^3/sqrt(Hz)
};

/// One raw sample as the integration sees it.
template <class S>
struct InertialReading {
  Vec3<S> gyro, accel;  ///< rad/s, m/s^2
};

/// Linear interpolation between two readings, u in [0, 1].
template <class S>
InertialReading<S> interpolate(const InertialReading<S>& a, const InertialReading<S>& b, S u) {
  return {a.gyro + u * (b.gyro - a.gyro), a.accel + u * (b.accel - a.accel)};
}

}  // namespace SEGCAL_NS
