// Landmarks as direction and inverse distance from a fixed point: l = o + m / rho.
//
// A landmark without parallax is a direction (rho near 0) and stays a regular, finite parameter: rotation in place
// never puts points "far away". o is the position of the camera that saw it first, a constant and not a state, so a row
// of the Jacobian touches one pose only. Projection uses h = R_CI R_IG (m + rho (o - p_GI)) + rho p_CI (paper,
// Eq. (landmark_proj), times rho).
#pragma once

#include "sensors/camera.h"
#include "sensors/inertial_state.h"

namespace SEGCAL_NS {

constexpr int kLandmarkColumns = 3;

template <class S>
struct Landmark {
  Vec3<S> o;  ///< m, in G
  Vec3<S> m;  ///< unit direction from o, in G
  S rho;      ///< 1/m
};

/// Two unit vectors perpendicular to m and to each other; continuous where it matters (a landmark keeps its m).
template <class S>
void tangent_basis(const Vec3<S>& m, Vec3<S>* e1, Vec3<S>* e2) {
  const Vec3<S> helper = absolute(m.z()) < S(0.7) ? Vec3<S>(S(0), S(0), S(1)) : Vec3<S>(S(1), S(0), S(0));
  const Vec3<S> a = cross<S>(m, helper);
  *e1 = a / square_root(a.squaredNorm());
  *e2 = cross<S>(m, *e1);
}

/// (alpha, beta, d rho): m <- (m + alpha e1 + beta e2) / |.|, rho <- (rho + d rho) / |.|, so that l moves exactly so.
template <class S>
void add_step(Landmark<S>* l, const S* d) {
  Vec3<S> e1, e2;
  tangent_basis(l->m, &e1, &e2);
  const Vec3<S> m = l->m + d[0] * e1 + d[1] * e2;
  const S n = square_root(m.squaredNorm());
  l->m = m / n;
  l->rho = (l->rho + d[2]) / n;
}

/// Residual r = predicted - measured (px) and its Jacobians; not whitened.
template <class S>
struct ReprojectionRows {
  Vec2<S> r;
  Mat<S, 2, kLandmarkColumns> J_l;
  Mat<S, 2, 6> J_pose;                    ///< by (theta, p) of the keyframe
  Mat<S, 2, kMaxCameraColumns> J_camera;  ///< by (r_CI, p_CI, fx fy cx cy, distortion)
  Vec2<S> d;                              ///< distorted point, before focal length and image terms
};

/// The point in C times rho.
template <class S>
Vec3<S> homogeneous_in_camera(const CameraCalibration<S>& camera, const Mat3<S>& R_GI, const Vec3<S>& p_GI,
                              const Landmark<S>& l) {
  const Vec3<S> h_I = R_GI.transpose() * (l.m + l.rho * (l.o - p_GI));
  return camera.R_CI * h_I + l.rho * camera.p_CI;
}

/// Predicted pixel minus `uv`. False where the landmark has no image in this pose.
template <class S>
bool reprojection_residual(const CameraCalibration<S>& camera, const Mat3<S>& R_GI, const Vec3<S>& p_GI,
                           const Landmark<S>& l, const Vec2<S>& uv, Vec2<S>* r, const ImageTerms<S>& terms = {}) {
  Vec2<S> predicted;
  if (!project<S>(camera, homogeneous_in_camera(camera, R_GI, p_GI, l), &predicted, nullptr, nullptr, terms))
    return false;
  *r = predicted - uv;
  return true;
}

/// A number's derivatives by landmark, pose of the keyframe and extrinsics.
template <class S>
struct LandmarkRow {
  Vec<S, kLandmarkColumns> l;
  Vec<S, 6> pose, extrinsics;
};

/// A landmark in a camera, h = R_CG (m + rho (o - c)), and the derivatives of any function of h.
template <class S>
struct LandmarkInCamera {
  const CameraCalibration<S>& camera;
  const Mat3<S>& R_GI;
  S rho;
  Vec3<S> from_I, h_I, rotated, h, e1, e2;

  [[gnu::always_inline]] LandmarkInCamera(const CameraCalibration<S>& in, const Mat3<S>& R, const Vec3<S>& p_GI,
                                          const Landmark<S>& l)
      : camera(in), R_GI(R), rho(l.rho), from_I(l.o - p_GI) {
    const Vec3<S> in_G = l.m + l.rho * from_I;
    h_I = R.transpose() * in_G;
    rotated = in.R_CI * h_I;
    h = rotated + l.rho * in.p_CI;
    tangent_basis(l.m, &e1, &e2);
  }

  [[gnu::always_inline]] LandmarkRow<S> row_by(const Vec3<S>& by_h) const {
    const Vec3<S> by_I = camera.R_CI.transpose() * by_h;     // by h_I
    const Vec3<S> by_G = R_GI * by_I;                        // by the bracket in G
    const Vec3<S> by_turn = cross<S>(by_I, h_I);             // R <- R Exp(d): h_I moves by [h_I]x d
    const Vec3<S> by_camera_turn = cross<S>(rotated, by_h);  // R_CI <- Exp(d) R_CI: h moves by -[rotated]x d
    LandmarkRow<S> out;
    out.l = Vec3<S>(by_G.dot(e1), by_G.dot(e2), by_G.dot(from_I) + by_h.dot(camera.p_CI));
    for (int c = 0; c < 3; ++c) {
      out.pose(c) = by_turn(c);
      out.pose(3 + c) = -rho * by_G(c);
      out.extrinsics(c) = by_camera_turn(c);
      out.extrinsics(3 + c) = rho * by_h(c);
    }
    return out;
  }
};

/// Predicted pixel and its Jacobians at (R_GI, p_GI).
template <class S>
bool reprojection_jacobians(const CameraCalibration<S>& camera, const Mat3<S>& R_GI, const Vec3<S>& p_GI,
                            const Landmark<S>& l, Vec2<S>* predicted, ReprojectionRows<S>* rows,
                            const ImageTerms<S>& terms = {}) {
  const LandmarkInCamera<S> at(camera, R_GI, p_GI, l);
  Mat<S, 2, 3> J_h;
  Mat<S, 2, kIntrinsicColumns> J_i;
  if (!project(camera, at.h, predicted, &J_h, &J_i, terms, &rows->d)) return false;
  for (int i = 0; i < 2; ++i) {
    const LandmarkRow<S> row = at.row_by(Vec3<S>(J_h(i, 0), J_h(i, 1), J_h(i, 2)));
    for (int c = 0; c < kLandmarkColumns; ++c) rows->J_l(i, c) = row.l(c);
    for (int c = 0; c < 6; ++c) {
      rows->J_pose(i, c) = row.pose(c);
      rows->J_camera(i, c) = row.extrinsics(c);
    }
  }
  rows->J_camera.template rightCols<kIntrinsicColumns>() = J_i;
  return true;
}

/// Residual and Jacobians at the same pose.
template <class S>
bool reprojection_rows(const CameraCalibration<S>& camera, const Mat3<S>& R_GI, const Vec3<S>& p_GI,
                       const Landmark<S>& l, const Vec2<S>& uv, ReprojectionRows<S>* rows,
                       const ImageTerms<S>& terms = {}) {
  Vec2<S> predicted;
  if (!reprojection_jacobians(camera, R_GI, p_GI, l, &predicted, rows, terms)) return false;
  rows->r = predicted - uv;
  return true;
}

/// Residual at (R_GI, p_GI); Jacobians at (R_j, p_j), which
/// differ from them only in a filter that keeps first estimates.
template <class S>
bool reprojection_rows(const CameraCalibration<S>& camera, const Mat3<S>& R_GI, const Vec3<S>& p_GI, const Mat3<S>& R_j,
                       const Vec3<S>& p_j, const Landmark<S>& l, const Vec2<S>& uv, ReprojectionRows<S>* rows,
                       const ImageTerms<S>& terms = {}) {
  if (!reprojection_residual(camera, R_GI, p_GI, l, uv, &rows->r, terms)) return false;
  Vec2<S> unused;
  return reprojection_jacobians(camera, R_j, p_j, l, &unused, rows, terms);
}

}  // namespace SEGCAL_NS
