// Camera models fov, radtan, equidistant: value and optional Jacobians from one call.
//
// All three are p = (fx x_d + cx, fy y_d + cy) with (x_d, y_d) = beta(q) (x, y) + tangential, q = x^2 + y^2
// (radial_factor.h); where the plane z = 1 ends an equidistant lens is taken by the angle (wide_angle.h).
#pragma once

#include "sensors/image_terms.h"
#include "sensors/radial_factor.h"
#include "sensors/wide_angle.h"

namespace SEGCAL_NS {

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
  const S length = square_root(h.squaredNorm());
  if (camera.model == Distortion::equidistant)
    return h.z() > S(-0.139) * length && equidistant_slope(camera.distortion, h) > S(0.07);
  if (!(h.z() > S(0.2) * length)) return false;
  const S q = (h.x() * h.x() + h.y() * h.y()) / (h.z() * h.z());
  const RadialFactor<S> f = radial_factor(camera, q);
  return f.beta + S(2) * q * f.slope > S(0.07);
}

/// Derivatives of a pixel by fx fy cx cy and the coefficients, from those of the distorted point by these.
template <class S>
[[gnu::always_inline]] inline void intrinsic_columns(const CameraCalibration<S>& camera, const Vec2<S>& d,
                                                     const Mat<S, 2, 4>& J_d, Mat<S, 2, kIntrinsicColumns>* J) {
  J->setZero();
  (*J)(0, 0) = d.x();
  (*J)(1, 1) = d.y();
  (*J)(0, 2) = S(1);
  (*J)(1, 3) = S(1);
  for (int i = 0; i < camera.distortion_columns(); ++i) {
    (*J)(0, 4 + i) = camera.intrinsics(0) * J_d(0, i);
    (*J)(1, 4 + i) = camera.intrinsics(1) * J_d(1, i);
  }
}

/// project() by the angle from the axis: the equidistant lens, where the plane z = 1 holds its directions no more.
template <class S>
[[gnu::cold, gnu::noinline]] bool project_wide(const CameraCalibration<S>& camera, const Vec3<S>& h, Vec2<S>* uv,
                                               Mat<S, 2, 3>* J_h, Mat<S, 2, kIntrinsicColumns>* J_intrinsics,
                                               const ImageTerms<S>& terms, Vec2<S>* distorted) {
  if (camera.model != Distortion::equidistant) return false;
  Vec2<S> d;
  Mat<S, 2, 4> J_d;
  if (!distort_wide(camera.distortion, h, &d, J_h, J_intrinsics ? &J_d : nullptr)) return false;
  if (distorted) *distorted = d;
  if (terms.effects) {
    Mat<S, 2, 2> J_move;
    move_image_point(terms, &d, &J_move);
    if (J_h) *J_h = (J_move * *J_h).eval();
    if (J_intrinsics) J_d = (J_move * J_d).eval();
  }
  const S fx = camera.intrinsics(0), fy = camera.intrinsics(1);
  *uv = Vec2<S>(fx * d.x() + camera.intrinsics(2), fy * d.y() + camera.intrinsics(3));
  for (int i = 0; J_h && i < 3; ++i) {
    (*J_h)(0, i) *= fx;
    (*J_h)(1, i) *= fy;
  }
  if (J_intrinsics) intrinsic_columns(camera, d, J_d, J_intrinsics);
  return true;
}

/// Projects a homogeneous direction h in C (any positive scale) to pixels; paper, Eq. (landmark_proj).
/// Optional: J_h (2x3) by h, J_intrinsics (2x8) by fx fy cx cy and the coefficients. `terms` move the distorted point;
/// `distorted` takes it as it was before.
/// False if the point is more than 80 degrees from the axis (equidistant: 100), or has no image.
template <class S>
bool project(const CameraCalibration<S>& camera, const Vec3<S>& h, Vec2<S>* uv, Mat<S, 2, 3>* J_h = nullptr,
             Mat<S, 2, kIntrinsicColumns>* J_intrinsics = nullptr, const ImageTerms<S>& terms = {},
             Vec2<S>* distorted = nullptr) {
  if (!(h.z() > S(0.17) * h.norm())) return project_wide(camera, h, uv, J_h, J_intrinsics, terms, distorted);
  const S iz = S(1) / h.z();
  const Vec2<S> xy(h.x() * iz, h.y() * iz);
  Vec2<S> d;
  Mat<S, 2, 2> J_xy;
  Mat<S, 2, 4> J_d;
  if (!distort(camera, xy, &d, J_h ? &J_xy : nullptr, J_intrinsics ? &J_d : nullptr))
    return project_wide(camera, h, uv, J_h, J_intrinsics, terms, distorted);
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
  if (J_intrinsics) intrinsic_columns(camera, d, J_d, J_intrinsics);
  return true;
}

/// Pixels to a direction in C: (x, y, 1) by Newton's method on the distortion; of unit length where an equidistant lens
/// is beyond a distorted radius of 1, some 57 degrees. False if there is none, or it does not converge.
template <class S>
bool unproject(const CameraCalibration<S>& camera, const Vec2<S>& uv, Vec3<S>* h) {
  const Vec2<S> target((uv.x() - camera.intrinsics(2)) / camera.intrinsics(0),
                       (uv.y() - camera.intrinsics(3)) / camera.intrinsics(1));
  if (camera.model == Distortion::equidistant && target.squaredNorm() > S(1))
    return undistort_wide(camera.distortion, target, h);
  const S tolerance = std::is_same_v<S, float> ? S(2e-6) : S(1e-12);
  Vec2<S> xy = target;
  for (int i = 0; i < 15; ++i) {
    Vec2<S> d;
    Mat<S, 2, 2> J;
    if (!distort<S>(camera, xy, &d, &J, nullptr)) {
      xy *= S(0.7);  // beyond the fold: come back towards the centre
      continue;
    }
    const Vec2<S> e = target - d;
    const S det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
    xy += Vec2<S>(J(1, 1) * e.x() - J(0, 1) * e.y(), J(0, 0) * e.y() - J(1, 0) * e.x()) / det;
    *h = Vec3<S>(xy.x(), xy.y(), S(1));
    if (absolute(e.x()) + absolute(e.y()) < tolerance) return true;
  }
  return false;
}

}  // namespace SEGCAL_NS
