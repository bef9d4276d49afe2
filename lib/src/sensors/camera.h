// Camera models fov, radtan, equidistant: value and optional Jacobians from one call.
//
// All three are p = (fx x_d + cx, fy y_d + cy) with (x_d, y_d) = beta(q) (x, y) + tangential, q = x^2 + y^2.
// beta is written as a smooth function of q, so nothing is singular at the image centre.
#pragma once

#include "math/elementary.h"
#include "sensors/calibration.h"
#include "sensors/image_terms.h"

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

/// Distorts a normalised point. Optional: J_xy (2x2) by (x, y), J_d (2x4) by the coefficients.
/// False where the model folds back on itself (its radius no longer grows): such a point has no image.
template <class S>
bool distort(const CameraCalibration<S>& camera, const Vec2<S>& xy, Vec2<S>* out, Mat<S, 2, 2>* J_xy,
             Mat<S, 2, 4>* J_d) {
  const S x = xy.x(), y = xy.y(), q = x * x + y * y;
  const RadialFactor<S> f = radial_factor(camera, q);
  if (!(f.beta + S(2) * q * f.slope > S(0.05))) return false;
  *out = f.beta * xy;
  if (J_xy) {
    *J_xy << f.beta + S(2) * x * x * f.slope, S(2) * x * y * f.slope, S(2) * x * y * f.slope,
        f.beta + S(2) * y * y * f.slope;
  }
  if (J_d) {
    for (int i = 0; i < 4; ++i) J_d->col(i) = f.by_coefficient[i] * xy;
  }
  if (camera.model == Distortion::radtan) {
    const S p1 = camera.distortion(2), p2 = camera.distortion(3);
    *out += Vec2<S>(S(2) * p1 * x * y + p2 * (q + S(2) * x * x), p1 * (q + S(2) * y * y) + S(2) * p2 * x * y);
    if (J_xy) {
      Mat<S, 2, 2> T;
      T << S(2) * p1 * y + S(6) * p2 * x, S(2) * p1 * x + S(2) * p2 * y, S(2) * p1 * x + S(2) * p2 * y,
          S(6) * p1 * y + S(2) * p2 * x;
      *J_xy += T;
    }
    if (J_d) {
      J_d->col(2) = Vec2<S>(S(2) * x * y, q + S(2) * y * y);
      J_d->col(3) = Vec2<S>(q + S(2) * x * x, S(2) * x * y);
    }
  }
  return true;
}

/// Does a direction h in C have an image, away from the lens' edge (two degrees inside it for a wide lens)? At
/// the edge a point leaves the cost in a jump, and a fit that balances there does not settle.
template <class S>
[[gnu::cold]] bool well_inside(const CameraCalibration<S>& camera, const Vec3<S>& h) {
  if (!(h.z() > S(0.2) * square_root(h.squaredNorm()))) return false;
  const S q = (h.x() * h.x() + h.y() * h.y()) / (h.z() * h.z());
  const RadialFactor<S> f = radial_factor(camera, q);
  return f.beta + S(2) * q * f.slope > S(0.07);
}

/// Projects a homogeneous direction h in C (any positive scale) to pixels; paper, Eq. (landmark_proj).
/// Optional: J_h (2x3) by h, J_intrinsics (2x8) by fx fy cx cy and the coefficients. `terms` move the distorted point;
/// `distorted` takes it as it was before.
/// False if the point is behind the camera, closer than 80 degrees to the image plane's horizon, or has no image.
template <class S>
bool project(const CameraCalibration<S>& camera, const Vec3<S>& h, Vec2<S>* uv, Mat<S, 2, 3>* J_h = nullptr,
             Mat<S, 2, kIntrinsicColumns>* J_intrinsics = nullptr, const ImageTerms<S>& terms = {},
             Vec2<S>* distorted = nullptr) {
  if (!(h.z() > S(0.17) * h.norm())) return false;
  const S iz = S(1) / h.z();
  const Vec2<S> xy(h.x() * iz, h.y() * iz);
  Vec2<S> d;
  Mat<S, 2, 2> J_xy;
  Mat<S, 2, 4> J_d;
  if (!distort(camera, xy, &d, J_h ? &J_xy : nullptr, J_intrinsics ? &J_d : nullptr)) return false;
  if (distorted) *distorted = d;
  if (terms.effects) {
    Mat<S, 2, 2> J_move;
    move_image_point(terms, &d, &J_move);
    if (J_h) J_xy = (J_move * J_xy).eval();
    if (J_intrinsics) J_d = (J_move * J_d).eval();
  }
  const S fx = camera.intrinsics(0), fy = camera.intrinsics(1);
  *uv = Vec2<S>(fx * d.x() + camera.intrinsics(2), fy * d.y() + camera.intrinsics(3));
  if (J_h) {
    const S focal[2] = {fx * iz, fy * iz};
    for (int i = 0; i < 2; ++i) {
      (*J_h)(i, 0) = focal[i] * J_xy(i, 0);
      (*J_h)(i, 1) = focal[i] * J_xy(i, 1);
      (*J_h)(i, 2) = -focal[i] * (J_xy(i, 0) * xy.x() + J_xy(i, 1) * xy.y());
    }
  }
  if (J_intrinsics) {
    J_intrinsics->setZero();
    (*J_intrinsics)(0, 0) = d.x();
    (*J_intrinsics)(1, 1) = d.y();
    (*J_intrinsics)(0, 2) = S(1);
    (*J_intrinsics)(1, 3) = S(1);
    for (int i = 0; i < camera.distortion_columns(); ++i) {
      (*J_intrinsics)(0, 4 + i) = fx * J_d(0, i);
      (*J_intrinsics)(1, 4 + i) = fy * J_d(1, i);
    }
  }
  return true;
}

/// Pixels to a normalised point (x, y, 1) by Newton's method on the distortion. False if it does not converge.
template <class S>
bool unproject(const CameraCalibration<S>& camera, const Vec2<S>& uv, Vec2<S>* xy) {
  const Vec2<S> target((uv.x() - camera.intrinsics(2)) / camera.intrinsics(0),
                       (uv.y() - camera.intrinsics(3)) / camera.intrinsics(1));
  const S tolerance = std::is_same_v<S, float> ? S(2e-6) : S(1e-12);
  *xy = target;
  for (int i = 0; i < 15; ++i) {
    Vec2<S> d;
    Mat<S, 2, 2> J;
    if (!distort<S>(camera, *xy, &d, &J, nullptr)) {
      *xy *= S(0.7);  // beyond the fold: come back towards the centre
      continue;
    }
    const Vec2<S> e = target - d;
    const S det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
    *xy += Vec2<S>(J(1, 1) * e.x() - J(0, 1) * e.y(), J(0, 0) * e.y() - J(1, 0) * e.x()) / det;
    if (absolute(e.x()) + absolute(e.y()) < tolerance) return true;
  }
  return false;
}

}  // namespace SEGCAL_NS
