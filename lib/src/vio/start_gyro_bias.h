// The start, part 2: gyroscope bias from image points.
//
// Two frames with known relative rotation R see a point along f1 and f2; the three vectors f1, R f2 and the camera's
// displacement lie in one plane: t' (f1 x R f2) = 0 (Kneip and Lynen 2013). R comes from the gyroscope, so the only
// unknowns are its bias, common to all pairs, and one direction t per pair, which is eliminated.
// Pairs are folded one by one (start_motion.h).
#pragma once

#include "math/small_solvers.h"
#include "vio/start_links.h"

namespace SEGCAL_NS {

/// Rotation between two frames of the window, and its right perturbation by b_g.
template <class S>
void rotation_between(const StartScratch<S>& s, int i, int j, Mat3<S>* R, Mat3<S>* R_bg) {
  *R = s.link[i].dR.transpose() * s.link[j].dR;
  *R_bg = s.link[j].R_bg - R->transpose() * s.link[i].R_bg;
}

/// The direction that is nearest to perpendicular to all rows: smallest singular vector by inverse iteration.
template <class S>
Vec3<S> smallest_direction(const PackedTriangle<S>& R) {
  Vec3<S> x(S(0.6), S(0.5), S(0.62));
  for (int iteration = 0; iteration < 8; ++iteration) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < j; ++k) x(j) -= R(k, j) * x(k);
      x(j) /= R(j, j) + (R(j, j) < S(0) ? S(-1e-6) : S(1e-6));
    }
    for (int j = 2; j >= 0; --j) {
      for (int k = j + 1; k < 3; ++k) x(j) -= R(j, k) * x(k);
      x(j) /= R(j, j) + (R(j, j) < S(0) ? S(-1e-6) : S(1e-6));
    }
    x /= square_root(x.squaredNorm());
  }
  return x;
}

/// Direction of the displacement between frames i and j of one camera.
template <class S>
bool displacement_direction(const Window<S>& w, const TrackTable<S>& tracks, int camera, int i, int j, const Mat3<S>& R,
                            Vec3<S>* t) {
  S data[packed_size(3)], row[3];
  PackedTriangle<S> triangle(data, 3);
  triangle.clear();
  int n = 0;
  for (int k = 0; k < tracks.end(); ++k) {
    Vec3<S> f1, f2;
    if (!tracks[k].used || tracks[k].camera != camera) continue;
    if (!bearing_in_imu(w, tracks[k], i, &f1) || !bearing_in_imu(w, tracks[k], j, &f2)) continue;
    const Vec3<S> normal = cross<S>(f1, Vec3<S>(R * f2));
    for (int c = 0; c < 3; ++c) row[c] = normal(c);
    fold_rows(triangle, row, 1, 3, 0, 3);
    ++n;
  }
  if (n < 8) return false;
  *t = smallest_direction(triangle);
  return true;
}

/// Rows of one pair: [t 2 | b_g 3 | rhs], t eliminated; the rest folded into `total` (b_g 3 | rhs).
template <class S>
void fold_pair(const Window<S>& w, const TrackTable<S>& tracks, const StartScratch<S>& s, int camera, int i, int j,
               S sigma, PackedTriangle<S>* total) {
  Mat3<S> R, R_bg;
  rotation_between(s, i, j, &R, &R_bg);
  Vec3<S> t, e1, e2;
  if (!displacement_direction(w, tracks, camera, i, j, R, &t)) return;
  tangent_basis(t, &e1, &e2);
  S data[packed_size(6)], row[6];
  PackedTriangle<S> pair(data, 6);
  pair.clear();
  for (int k = 0; k < tracks.end(); ++k) {
    Vec3<S> f1, f2;
    if (!tracks[k].used || tracks[k].camera != camera) continue;
    if (!bearing_in_imu(w, tracks[k], i, &f1) || !bearing_in_imu(w, tracks[k], j, &f2)) continue;
    const Vec3<S> normal = cross<S>(f1, Vec3<S>(R * f2));
    const S e = t.dot(normal);
    const S weight = S(1) / (sigma * square_root(S(1) + e * e / (S(9) * sigma * sigma)));  // Cauchy
    const Vec3<S> by_bias = (skew(f1) * (R * skew(f2) * R_bg)).transpose() * t;
    row[0] = weight * normal.dot(e1);
    row[1] = weight * normal.dot(e2);
    for (int c = 0; c < 3; ++c) row[2 + c] = -weight * by_bias(c);
    row[5] = -weight * e;
    fold_rows(pair, row, 1, 6, 0, 6);
  }
  for (int r = 2; r < 5; ++r) {
    for (int c = 0; c < 4; ++c) row[c] = c + 2 < r ? S(0) : pair(r, c + 2);
    fold_rows(*total, row, 1, 4, r - 2, 3);
  }
}

/// Prior of the bias at x0's, the equations' beginning.
template <class S>
void begin_gyro_bias(const VioOptions<S>& options, const StartScratch<S>& s, PackedTriangle<S>* total) {
  total->clear();
  for (int c = 0; c < 3; ++c) {
    total->row(c)[c] = S(1) / options.sigma_b_g;
    total->row(c)[3] = -s.x0.b_g(c) / options.sigma_b_g;
  }
}

template <class S>
void solve_gyro_bias(const PackedTriangle<S>& total, StartScratch<S>* s) {
  S step[3] = {total(0, 3), total(1, 3), total(2, 3)};
  back_substitute(total, 3, step);
  s->x0.b_g += Vec3<S>(step[0], step[1], step[2]);
}

}  // namespace SEGCAL_NS
