// The inertial link, written a second time for automatic derivatives: the raw samples are corrected and integrated
// again with Jets through the whole chain of steps, so that every derivative comes from the chain itself.
#pragma once

#include <vector>

#include "jet_camera.h"
#include "sensors/imu_link.h"

namespace jet {

/// Raw samples of a link; the first one is at its start.
struct Samples {
  std::vector<InertialReading<double>> reading;
  double dt = 0.005;  ///< s between samples
};

constexpr int kLinkColumns = 2 * kStateColumns + kImuColumns;

template <class T>
using V3 = Eigen::Matrix<T, 3, 1>;

template <class T>
V3<T> vector(const T* v) {
  return {v[0], v[1], v[2]};
}

/// Solves T x = y for T = [[sx, mx, my], [0, sy, mz], [0, 0, sz]] from the last row up.
template <class T>
V3<T> solve_upper(const V3<T>& s, const V3<T>& m, const V3<T>& y) {
  V3<T> x;
  x[2] = y[2] / s[2];
  x[1] = (y[1] - m[2] * x[2]) / s[1];
  x[0] = (y[0] - m[0] * x[1] - m[1] * x[2]) / s[0];
  return x;
}

/// A keyframe's state after the step d (15 entries).
template <class T>
struct JetState {
  Eigen::Quaternion<T> q;
  V3<T> p, v, b_a, b_g;
  JetState(const State<double>& x, const T* d)
      : q(quaternion<T>(x.R_GI) * exponential(d)),
        p(x.p_GI.cast<T>() + vector(d + 3)),
        v(x.v_GI.cast<T>() + vector(d + 6)),
        b_a(x.b_a.cast<T>() + vector(d + 9)),
        b_g(x.b_g.cast<T>() + vector(d + 12)) {}
};

/// The inertial part of theta after the step d (15 entries).
template <class T>
struct JetImu {
  V3<T> gs, gm, as, am;
  Eigen::Quaternion<T> q_AI;
  JetImu(const ImuCalibration<double>& imu, const T* d)
      : gs(imu.gyro_scale.cast<T>() + vector(d)),
        gm(imu.gyro_misalignment.cast<T>() + vector(d + 3)),
        as(imu.accel_scale.cast<T>() + vector(d + 6)),
        am(imu.accel_misalignment.cast<T>() + vector(d + 9)),
        q_AI(exponential(d + 12) * quaternion<T>(imu.R_AI)) {}
  V3<T> rate(const V3<double>& gyro, const V3<T>& b_g) const { return solve_upper<T>(gs, gm, gyro.cast<T>() - b_g); }
  V3<T> force(const V3<double>& accel, const V3<T>& b_a) const {
    return q_AI.conjugate() * solve_upper<T>(as, am, accel.cast<T>() - b_a);
  }
};

/// Residual of the link: rotation, velocity, position, b_a, b_g; d holds the step of [state 0 | state 1 | theta].
template <class T>
Eigen::Matrix<T, 15, 1> link_residual(const Samples& samples, const ImuCalibration<double>& calibration,
                                      const State<double>& s0, const State<double>& s1, const V3<double>& gravity,
                                      const T* d) {
  const JetState<T> x0(s0, d), x1(s1, d + kStateColumns);
  const JetImu<T> imu(calibration, d + 2 * kStateColumns);
  Eigen::Quaternion<T> q = Eigen::Quaternion<T>::Identity();
  V3<T> v = V3<T>::Zero(), p = V3<T>::Zero();
  const T h(samples.dt);
  V3<T> w = imu.rate(samples.reading[0].gyro, x0.b_g), f = imu.force(samples.reading[0].accel, x0.b_a);
  for (std::size_t i = 1; i < samples.reading.size(); ++i) {
    const V3<T> w1 = imu.rate(samples.reading[i].gyro, x0.b_g), f1 = imu.force(samples.reading[i].accel, x0.b_a);
    // Linear rate: half a step and all of it, each with the second term of Magnus' series.
    const V3<T> wm = (w + w1) / T(2), fm = (f + f1) / T(2);
    const V3<T> turn_m = (w + wm) * (h / T(4)) + w.cross(wm) * (h * h / T(48));
    const V3<T> turn = wm * h + w.cross(w1) * (h * h / T(12));
    const V3<T> a = q * f, am = (q * exponential(turn_m.data())) * fm;
    q = q * exponential(turn.data());
    const V3<T> a1 = q * f1;
    p += v * h + (a + T(2) * am) * (h * h / T(6));
    v += (a + T(4) * am + a1) * (h / T(6));
    w = w1;
    f = f1;
  }
  const T t(samples.dt * double(samples.reading.size() - 1));
  const V3<T> g = gravity.cast<T>();
  Eigen::Matrix<T, 15, 1> r;
  r.template segment<3>(0) = logarithm<T>(q.conjugate() * (x0.q.conjugate() * x1.q));
  r.template segment<3>(3) = x0.q.conjugate() * (x1.v - x0.v - g * t) - v;
  r.template segment<3>(6) = x0.q.conjugate() * (x1.p - x0.p - x0.v * t - g * (t * t / T(2))) - p;
  r.template segment<3>(9) = x1.b_a - x0.b_a;
  r.template segment<3>(12) = x1.b_g - x0.b_g;
  return r;
}

}  // namespace jet
