// The equidistant lens (Kannala and Brandt, "A generic camera model and calibration method for conventional,
// wide-angle, and fish-eye lenses", PAMI 28, 2006, eq. 6) by the angle from the axis, for directions that the plane z =
// 1 holds badly or not at all. With u = (h_x, h_y), r = |u| and theta = atan2(r, h_z) in (0, pi):
//
//   d = rho(theta) u / r      rho = theta (1 + k1 theta^2 + ... + k4 theta^8)
#pragma once

#include "math/elementary.h"
#include "math/types.h"

namespace SEGCAL_NS {

/// Cosine of the farthest angle from the axis: 100 degrees.
template <class S>
constexpr S kWidestCosine = S(-0.17364818);

/// rho and its derivative at theta.
template <class S>
void equidistant_radius(const Vec<S, 4>& k, S theta, S* rho, S* slope) {
  const S t2 = theta * theta;
  *rho = theta * (S(1) + t2 * (k(0) + t2 * (k(1) + t2 * (k(2) + t2 * k(3)))));
  *slope = S(1) + t2 * (S(3) * k(0) + t2 * (S(5) * k(1) + t2 * (S(7) * k(2) + t2 * S(9) * k(3))));
}

/// d rho / d theta at a direction h in C: towards the lens' fold it falls to zero.
template <class S>
[[gnu::cold]] S equidistant_slope(const Vec<S, 4>& k, const Vec3<S>& h) {
  S rho, slope;
  equidistant_radius(k, arc_tangent2(square_root(h.x() * h.x() + h.y() * h.y()), h.z()), &rho, &slope);
  return slope;
}

/// The distorted point of a direction h in C, any length, away from the axis. Optional: J_h by h, J_k by the
/// coefficients. False beyond 100 degrees and where the lens folds back on itself.
template <class S>
[[gnu::cold, gnu::noinline]] bool distort_wide(const Vec<S, 4>& k, const Vec3<S>& h, Vec2<S>* d, Mat<S, 2, 3>* J_h,
                                               Mat<S, 2, 4>* J_k) {
  const S r2 = h.x() * h.x() + h.y() * h.y(), n2 = r2 + h.z() * h.z();
  const S r = square_root(r2);
  if (!(r > S(0)) || !(h.z() > kWidestCosine<S> * square_root(n2))) return false;
  const S theta = arc_tangent2(r, h.z());
  S rho, slope;
  equidistant_radius(k, theta, &rho, &slope);
  if (!(slope > S(0.05))) return false;
  const Vec2<S> e(h.x() / r, h.y() / r);
  *d = rho * e;
  if (J_h) {
    // along e with theta, across e with the direction of e
    const S along = slope * h.z() / n2, across = rho / r;
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) (*J_h)(i, j) = (along - across) * e(i) * e(j) + (i == j ? across : S(0));
      (*J_h)(i, 2) = -slope * r / n2 * e(i);
    }
  }
  if (J_k) {
    S power = theta;
    for (int i = 0; i < 4; ++i) {
      power *= theta * theta;
      J_k->col(i) = power * e;
    }
  }
  return true;
}

/// The unit direction whose distorted point is d, not the axis; by Newton's method on theta. False where there is none
/// within 100 degrees.
template <class S>
[[gnu::cold, gnu::noinline]] bool undistort_wide(const Vec<S, 4>& k, const Vec2<S>& d, Vec3<S>* h) {
  const S wanted = square_root(d.squaredNorm());
  const S tolerance = std::is_same_v<S, float> ? S(1e-6) : S(1e-13);
  const S widest = S(1.7453293);
  S theta = wanted < S(1.5) ? wanted : S(1.5);
  for (int i = 0; i < 20; ++i) {
    S rho, slope;
    equidistant_radius(k, theta, &rho, &slope);
    if (!(slope > S(0.05))) {
      theta *= S(0.8);  // beyond the fold: come back towards the centre
      continue;
    }
    const S step = (wanted - rho) / slope;
    theta += step;
    if (!(absolute(step) < S(10)) || theta < S(0)) return false;
    if (absolute(step) > tolerance) continue;
    if (!(theta < widest)) return false;
    const S across = sine(theta) / wanted;
    *h = Vec3<S>(across * d.x(), across * d.y(), cosine(theta));
    return true;
  }
  return false;
}

}  // namespace SEGCAL_NS
