// SO(3): exponential, logarithm, right Jacobian and its inverse, quaternions (Hamilton, w first).
// Every function is finite and smooth through the identity: below a threshold the series is used, and the
// threshold is where series and closed form agree to the last bits of the type.
#pragma once

#include "math/elementary.h"
#include "math/types.h"

namespace SEGCAL_NS {

/// sin(t)/t, (1 - cos t)/t^2, (t - sin t)/t^3 as functions of t^2.
template <class S>
struct RotationSeries {
  S a, b, c;
};

template <class S>
RotationSeries<S> rotation_series(S t2) {
  const S threshold = std::is_same_v<S, float> ? S(0.25) : S(1e-2);
  if (t2 < threshold) {
    // Terms up to t^8: at the threshold the next one is below one ulp.
    const S a = S(1) + t2 * (S(-1) / S(6) + t2 * (S(1) / S(120) + t2 * (S(-1) / S(5040) + t2 * (S(1) / S(362880)))));
    const S b =
        S(0.5) + t2 * (S(-1) / S(24) + t2 * (S(1) / S(720) + t2 * (S(-1) / S(40320) + t2 * (S(1) / S(3628800)))));
    const S c = S(1) / S(6) +
                t2 * (S(-1) / S(120) + t2 * (S(1) / S(5040) + t2 * (S(-1) / S(362880) + t2 * (S(1) / S(39916800)))));
    return {a, b, c};
  }
  const S t = square_root(t2);
  S s, c;
  sin_cos(t, &s, &c);
  return {s / t, (S(1) - c) / t2, (t - s) / (t2 * t)};
}

/// Exp(phi): rotation by |phi| about phi; rad.
template <class S>
Mat3<S> so3_exp(const Vec3<S>& phi) {
  const RotationSeries<S> k = rotation_series<S>(phi.squaredNorm());
  const Mat3<S> K = skew(phi);
  return Mat3<S>::Identity() + k.a * K + k.b * (K * K);
}

/// Right Jacobian: Exp(phi + d) = Exp(phi) Exp(J_r(phi) d) to first order.
template <class S>
Mat3<S> so3_right_jacobian(const Vec3<S>& phi) {
  const RotationSeries<S> k = rotation_series<S>(phi.squaredNorm());
  const Mat3<S> K = skew(phi);
  return Mat3<S>::Identity() - k.b * K + k.c * (K * K);
}

/// Inverse of the right Jacobian, |phi| < 2 pi.
template <class S>
Mat3<S> so3_right_jacobian_inverse(const Vec3<S>& phi) {
  const S t2 = phi.squaredNorm();
  const Mat3<S> K = skew(phi);
  S e;  // (1 - (t/2) cot(t/2)) / t^2
  if (t2 < S(0.25)) {
    // Coefficients abs(B_2n) / (2n)!; at t = 1/2 the first one left out is 2e-17.
    e = S(1) / S(12) +
        t2 * (S(1) / S(720) +
              t2 * (S(1) / S(30240) +
                    t2 * (S(1) / S(1209600) + t2 * (S(1) / S(47900160) + t2 * (S(691) / S(1307674368000.0) +
                                                                               t2 * (S(1) / S(74724249600.0)))))));
  } else {
    const RotationSeries<S> k = rotation_series<S>(t2);
    e = (S(1) - k.a / (S(2) * k.b)) / t2;
  }
  return Mat3<S>::Identity() + S(0.5) * K + e * (K * K);
}

/// Unit quaternion (w, x, y, z) of a rotation matrix; the largest
/// component is found first, so it never divides by zero.
template <class S>
Vec<S, 4> quaternion_from_matrix(const Mat3<S>& R) {
  const S trace = R(0, 0) + R(1, 1) + R(2, 2);
  Vec<S, 4> q;
  if (trace > S(0)) {
    const S s = square_root(trace + S(1)) * S(2);
    q << s * S(0.25), (R(2, 1) - R(1, 2)) / s, (R(0, 2) - R(2, 0)) / s, (R(1, 0) - R(0, 1)) / s;
    return q;
  }
  int i = 0;
  if (R(1, 1) > R(0, 0)) i = 1;
  if (R(2, 2) > R(i, i)) i = 2;
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  const S s = square_root(S(1) + R(i, i) - R(j, j) - R(k, k)) * S(2);
  q(0) = (R(k, j) - R(j, k)) / s;
  q(1 + i) = s * S(0.25);
  q(1 + j) = (R(j, i) + R(i, j)) / s;
  q(1 + k) = (R(k, i) + R(i, k)) / s;
  return q;
}

/// Rotation matrix of a quaternion (w, x, y, z), which need not be exactly of unit length.
template <class S>
Mat3<S> matrix_from_quaternion(const Vec<S, 4>& q) {
  const S n = S(2) / q.squaredNorm();
  const S w = q(0), x = q(1), y = q(2), z = q(3);
  Mat3<S> R;
  R << S(1) - n * (y * y + z * z), n * (x * y - w * z), n * (x * z + w * y), n * (x * y + w * z),
      S(1) - n * (x * x + z * z), n * (y * z - w * x), n * (x * z - w * y), n * (y * z + w * x),
      S(1) - n * (x * x + y * y);
  return R;
}

/// Log(R): rotation vector with |Log| <= pi; rad.
template <class S>
Vec3<S> so3_log(const Mat3<S>& R) {
  Vec<S, 4> q = quaternion_from_matrix(R);
  if (q(0) < S(0)) q = -q;
  const Vec3<S> v = q.template tail<3>();
  const S n2 = v.squaredNorm();
  // 2 atan(n/w)/n; series in n^2 near the identity, where w is close to 1.
  if (n2 < S(1e-6)) return v * (S(2) / q(0)) * (S(1) - n2 / (S(3) * q(0) * q(0)));
  const S n = square_root(n2);
  return v * (S(2) * arc_tangent2(n, q(0)) / n);
}

/// Rotation vector of R nearest to `centre`, |centre| <= pi. The one with |Log| <= pi jumps from v to v - 2 pi v/|v| at
/// half turns; of these two, the one that moves smoothly with R around Exp(centre).
template <class S>
Vec3<S> so3_log_near(const Mat3<S>& R, const Vec3<S>& centre) {
  const Vec3<S> v = so3_log<S>(R);
  const S n = square_root(v.squaredNorm());
  if (n < S(1)) return v;  // the other one is longer than 5
  const Vec3<S> other = v * (S(1) - S(6.283185307179586) / n);
  return (other - centre).squaredNorm() < (v - centre).squaredNorm() ? other : v;
}

/// The nearest rotation after many products in rounded arithmetic (one step towards orthogonality by quaternion).
template <class S>
Mat3<S> renormalised(const Mat3<S>& R) {
  return matrix_from_quaternion(quaternion_from_matrix(R));
}

}  // namespace SEGCAL_NS
