// The start, part 3: velocity and gravity in one linear system (Dong-Si and Mourikis 2012; Martinelli 2014).
//
// With rotations known, a landmark l, the first velocity v0 and gravity g, all in the first frame's axes, obey
//   E' (R_CI R_0i' (l - v0 t - g t^2/2 - dp_i) + p_CI) = 0,  E the two directions perpendicular to the bearing,
// linear in (l, v0, g). l is eliminated track by track; |g| is known and makes the scale.
#pragma once

#include "math/small_solvers.h"
#include "vio/start_links.h"

namespace SEGCAL_NS {

constexpr int kAlignmentColumns = 10;  // l 3, v0 3, g 3, right-hand side

/// Rows of one track, each divided by its distance: then the residual is an angle. Unknown distances count as 2 m.
template <class S>
[[gnu::cold]] int alignment_rows(const Window<S>& w, const StartScratch<S>& s, const VioTrack<S>& track,
                                 const Vec3<S>* l, const Vec3<S>& v0, const Vec3<S>& g, S* rows) {
  const CameraCalibration<S>& camera = w.theta.camera[track.camera];
  int m = 0;
  for (int i = 0; i < w.n_poses; ++i) {
    Vec3<S> u, e1, e2;
    if (!track.in(w.pose[i].slot) || !unproject(camera, track.uv[w.pose[i].slot], &u)) continue;
    const StartLink<S>& link = s.link[i];
    u /= square_root(u.squaredNorm());
    tangent_basis(u, &e1, &e2);
    const Mat3<S> R_C0 = camera.R_CI * link.dR.transpose();
    S distance = S(2);
    if (l) {
      const Vec3<S> at = *l - v0 * link.t - g * (link.t * link.t / S(2)) - link.dp;
      distance = square_root((R_C0 * at + camera.p_CI).squaredNorm());
      if (distance < S(0.1)) distance = S(0.1);
    }
    for (int k = 0; k < 2; ++k, ++m) {
      const Vec3<S> e = k ? e2 : e1;
      const Vec3<S> a = R_C0.transpose() * e / distance;
      S* row = rows + m * kAlignmentColumns;
      for (int c = 0; c < 3; ++c) {
        row[c] = a(c);
        row[3 + c] = -a(c) * link.t;
        row[6 + c] = -a(c) * (link.t * link.t / S(2));
      }
      row[9] = a.dot(link.dp) - e.dot(camera.p_CI) / distance;
    }
  }
  return m;
}

/// The landmark for given v0 and g from a track's rows (they are destroyed).
template <class S>
bool alignment_landmark(S* rows, int m, const Vec3<S>& v0, const Vec3<S>& g, Vec3<S>* l) {
  reflect_leading_columns(rows, m, kAlignmentColumns, kAlignmentColumns, 3);
  for (int j = 2; j >= 0; --j) {
    const S* row = rows + j * kAlignmentColumns;
    S sum = row[9];
    for (int c = 0; c < 3; ++c) sum -= row[3 + c] * v0(c) + row[6 + c] * g(c);
    for (int c = j + 1; c < 3; ++c) sum -= row[c] * (*l)(c);
    if (absolute(row[j]) < S(1e-5)) return false;
    (*l)(j) = sum / row[j];
  }
  return is_finite(l->squaredNorm());
}

/// Minimises |R_g g - d| over |g| = magnitude by steps in the tangent plane; R_g is 3x3 upper triangular.
template <class S>
[[gnu::cold]] Vec3<S> gravity_on_sphere(const Mat3<S>& R_g, const Vec3<S>& d, S magnitude, Vec3<S> g) {
  for (int iteration = 0; iteration < 10; ++iteration) {
    Vec3<S> e1, e2;
    const Vec3<S> unit = g / magnitude;
    tangent_basis(unit, &e1, &e2);
    const Vec3<S> a1 = R_g * e1, a2 = R_g * e2, r = d - R_g * g;
    const S a11 = a1.squaredNorm(), a12 = a1.dot(a2), a22 = a2.squaredNorm();
    const S det = a11 * a22 - a12 * a12;
    if (!(det > S(1e-12) * a11 * a22)) return g;
    const S b1 = a1.dot(r), b2 = a2.dot(r);
    S s1 = (a22 * b1 - a12 * b2) / det, s2 = (a11 * b2 - a12 * b1) / det;
    const S length = square_root(s1 * s1 + s2 * s2), limit = S(0.3) * magnitude;
    if (length > limit) {
      s1 *= limit / length;
      s2 *= limit / length;
    }
    g += s1 * e1 + s2 * e2;
    g *= magnitude / square_root(g.squaredNorm());
  }
  return g;
}

/// Weight of a track by how it fits v0 and g: rows free of the landmark, residuals as angles, `sigma` of them (Cauchy).
template <class S>
S alignment_weight(const S* rows, int m, const Vec3<S>& v0, const Vec3<S>& g, S sigma) {
  S sum = S(0);
  for (int i = 0; i < m; ++i) {
    const S* row = rows + i * kAlignmentColumns;
    S e = row[9];
    for (int c = 0; c < 3; ++c) e -= row[3 + c] * v0(c) + row[6 + c] * g(c);
    sum += e * e;
  }
  return S(1) / square_root(S(1) + sum / (S(m) * S(9) * sigma * sigma));
}

/// Folds one track's rows, weighted by the distances that v0 and g imply once they are known.
template <class S>
bool fold_alignment_track(Window<S>* w, const StartScratch<S>& s, const VioTrack<S>& track, bool weighted,
                          const Vec3<S>& v0, const Vec3<S>& g, S sigma, PackedTriangle<S>* R) {
  int m = alignment_rows<S>(*w, s, track, nullptr, v0, g, w->block);
  if (m < 8) return false;
  if (weighted) {
    Vec3<S> l;
    if (!alignment_landmark(w->block, m, v0, g, &l)) return false;
    m = alignment_rows<S>(*w, s, track, &l, v0, g, w->block);
  }
  reflect_leading_columns(w->block, m, kAlignmentColumns, kAlignmentColumns, 3);
  if (weighted) {
    const S weight = alignment_weight(w->block + 3 * kAlignmentColumns, m - 3, v0, g, sigma);
    for (int i = 3 * kAlignmentColumns; i < m * kAlignmentColumns; ++i) w->block[i] *= weight;
  }
  fold_rows(*R, w->block + 3 * kAlignmentColumns + 3, m - 3, kAlignmentColumns, 0, 6);
  return true;
}

/// v0 and g from the folded tracks; false if they are no numbers.
template <class S>
bool solve_alignment(const PackedTriangle<S>& R, S magnitude, Vec3<S>* v0, Vec3<S>* g) {
  Mat3<S> R_g = Mat3<S>::Zero();
  Vec3<S> d;
  for (int r = 0; r < 3; ++r) {
    for (int c = r; c < 3; ++c) R_g(r, c) = R(3 + r, 3 + c);
    d(r) = R(3 + r, 6);
  }
  *g = gravity_on_sphere<S>(R_g, d, magnitude, *g);
  S x[6];
  for (int r = 0; r < 3; ++r) {
    x[r] = R(r, 6);
    for (int c = 0; c < 3; ++c) x[r] -= R(r, 3 + c) * (*g)(c);
  }
  back_substitute(R, 3, x);
  *v0 = Vec3<S>(x[0], x[1], x[2]);
  return is_finite(v0->squaredNorm());
}

/// Gravity direction if the velocity did not change over the window: the mean specific force, turned into frame 0.
template <class S>
Vec3<S> mean_gravity(const Window<S>& w, const StartScratch<S>& s, S magnitude) {
  const Vec3<S>& dv = s.link[w.n_poses - 1].dv;
  return dv * (-magnitude / square_root(dv.squaredNorm()));
}

/// One standard deviation of a bearing, rad.
template <class S>
S alignment_sigma(const Window<S>& w, const VioOptions<S>& options) {
  return S(2) * options.pixel_sigma / w.theta.camera[0].intrinsics(0);
}

}  // namespace SEGCAL_NS
