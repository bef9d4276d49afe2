// How far from the centre a lens draws a point: beta(q), q = x^2 + y^2 at z = 1, and its derivatives.
//
// beta is written as a smooth function of q, so nothing is singular at the image centre.
#pragma once

#include "math/elementary.h"
#include "sensors/calibration.h"

namespace SEGCAL_NS {

/// atan(sqrt(q)) / sqrt(q) and its derivative by q; q >= 0.
template <class S>
void arc_tangent_ratio(S q, S* g, S* dg) {
  if (q < S(0.03)) {
    // Alternating series; at q = 0.03 the first term left out is 1e-13 relative for g.
    S value = S(0), slope = S(0);
    for (int i = 8; i >= 0; --i) {
      const S c = S((i & 1) ? -1 : 1) / S(2 * i + 1);
      slope = slope * q + (i < 8 ? S((i & 1) ? 1 : -1) * S(i + 1) / S(2 * i + 3) : S(0));
      value = value * q + c;
    }
    *g = value;
    *dg = slope;
    return;
  }
  const S r = square_root(q);
  *g = arc_tangent(r) / r;
  *dg = (S(1) / (S(1) + q) - *g) / (S(2) * q);
}

/// beta(q), d beta / d q and d beta / d coefficient.
template <class S>
struct RadialFactor {
  S beta, slope;
  S by_coefficient[4];
};

/// fov (paper, Sec. III-B; Devernay and Faugeras): beta = atan(2 r tan(w/2)) / (w r), w in [0, 2.5] rad.
template <class S>
RadialFactor<S> fov_factor(S w, S q) {
  const S half = w / S(2), h2 = half * half;
  const S t = tangent(half);
  const S k = S(2) * t;
  S ratio, ratio_slope;  // k / w and its derivative by w; series where the quotient cancels
  if (w < (std::is_same_v<S, float> ? S(0.3) : S(0.1))) {
    ratio = S(1) + h2 * (S(1) / S(3) + h2 * (S(2) / S(15) + h2 * (S(17) / S(315) + h2 * S(62) / S(2835))));
    ratio_slope = half * (S(1) / S(3) + h2 * (S(4) / S(15) + h2 * (S(17) / S(105) + h2 * S(248) / S(2835))));
  } else {
    ratio = k / w;
    ratio_slope = (S(1) + t * t - ratio) / w;
  }
  S g, dg;
  arc_tangent_ratio(k * k * q, &g, &dg);
  RadialFactor<S> f{};
  f.beta = ratio * g;
  f.slope = ratio * dg * k * k;
  f.by_coefficient[0] = ratio_slope * g + ratio * dg * S(2) * k * q * (S(1) + t * t);
  return f;
}

/// Brown's radial part: beta = 1 + k1 q + k2 q^2.
template <class S>
RadialFactor<S> radtan_factor(const Vec<S, 4>& d, S q) {
  RadialFactor<S> f{};
  f.beta = S(1) + q * (d(0) + q * d(1));
  f.slope = d(0) + S(2) * q * d(1);
  f.by_coefficient[0] = q;
  f.by_coefficient[1] = q * q;
  return f;
}

/// Kannala-Brandt: beta = theta (1 + k1 theta^2 + ... + k4 theta^8) / r, theta = atan r.
template <class S>
RadialFactor<S> equidistant_factor(const Vec<S, 4>& d, S q) {
  S g, dg;
  arc_tangent_ratio(q, &g, &dg);
  const S t2 = q * g * g;
  const S t2_slope = g * g + S(2) * q * g * dg;
  const S poly = S(1) + t2 * (d(0) + t2 * (d(1) + t2 * (d(2) + t2 * d(3))));
  const S poly_slope = d(0) + t2 * (S(2) * d(1) + t2 * (S(3) * d(2) + t2 * S(4) * d(3)));
  RadialFactor<S> f{};
  f.beta = g * poly;
  f.slope = dg * poly + g * poly_slope * t2_slope;
  S power = g;
  for (int i = 0; i < 4; ++i) {
    power *= t2;
    f.by_coefficient[i] = power;
  }
  return f;
}

template <class S>
RadialFactor<S> radial_factor(const CameraCalibration<S>& camera, S q) {
  switch (camera.model) {
    case Distortion::fov: return fov_factor(camera.distortion(0), q);
    case Distortion::radtan: return radtan_factor(camera.distortion, q);
    default: return equidistant_factor(camera.distortion, q);
  }
}

}  // namespace SEGCAL_NS
