// The start, part 4: Levenberg-Marquardt over the window.
//
// Over a second the inertial integral is far more precise than the image, so every pose is
// a function of the first state: 15 columns, the cameras with their prior, and landmarks
// that are eliminated one by one. It only serves to find the point at which the filter
// linearises: the filter then weighs inertial noise and image points once more, properly.
// Where no motion fits the lens as it was given, it is among the unknowns too: a wide one that is off by its tolerance
// moves the image's corners by tens of pixels. Not before: over a second a wrong motion finds a lens that goes with it.
#pragma once

#include "math/quantiles.h"
#include "math/small_solvers.h"
#include "vio/sensor_priors.h"
#include "vio/start_links.h"
#include "vio/vio_update.h"

namespace SEGCAL_NS {

constexpr int kRefineColumns = kStateColumns + kMaxCameraColumns * kMaxCameras;
static_assert(2 * packed_size(kRefineColumns + 1) + packed_size(kFilterColumns + 1 - camera_column(0)) <=
                  packed_size(kFilterColumns + 1),
              "both fit where the filter will have R, without its rows of the sensors");

/// d (pose i) / d x0, by (theta, p).
template <class S>
void pose_by_start(const State<S>& x0, const StartLink<S>& link, Mat<S, 6, kStateColumns>* D) {
  D->setZero();
  D->template block<3, 3>(0, 0) = link.dR.transpose();
  D->template block<3, 3>(0, 12) = link.R_bg;
  D->template block<3, 3>(3, 0) = -(x0.R_GI * skew(link.dp));
  D->template block<3, 3>(3, 3).setIdentity();
  D->template block<3, 3>(3, 6) = Mat3<S>::Identity() * link.t;
  D->template block<3, 3>(3, 9) = x0.R_GI * link.p_ba;
  D->template block<3, 3>(3, 12) = x0.R_GI * link.p_bg;
}

/// Where the prior's rows go: first columns of theta, p, motion (v, b_a, b_g) and cameras, and columns per camera.
struct StartColumns {
  int theta, p, motion, camera, per_camera;
};

/// A camera's columns in a triangle over x0 and the cameras: the extrinsics, or those of the lens as well.
template <class S>
int columns_per_camera(const Window<S>& w, const PackedTriangle<S>& R) {
  return (R.columns() - 1 - kStateColumns) / w.theta.n_cameras;
}

/// One row `a / sigma` at `column` with right-hand side -value / sigma.
template <class S>
void fold_prior_row(PackedTriangle<S>* R, int column, const Vec3<S>& a, S value, S sigma, S* row) {
  const int n = R->columns() - 1;
  for (int c = 0; c <= n; ++c) row[c] = S(0);
  for (int c = 0; c < 3 && column + c < n; ++c) row[column + c] = a(c) / sigma;
  row[n] = -value / sigma;
  fold_rows(*R, row, 1, n + 1, column, n);
}

/// Prior of the cameras, at what was given from outside.
template <class S>
[[gnu::cold]] void fold_camera_prior(const Window<S>& w, const VioOptions<S>& options, PackedTriangle<S>* R,
                                     const StartColumns& at, S* row) {
  for (int c = 0; c < w.theta.n_cameras; ++c) {
    const CameraCalibration<S>&now = w.theta.camera[c], &given = w.given.camera[c];
    const Vec3<S> r = so3_log<S>(now.R_CI * given.R_CI.transpose()), dp = now.p_CI - given.p_CI;
    for (int i = 0; i < at.per_camera; ++i) {
      const S sigma = camera_sigma(options, given, i);
      if (sigma == S(0)) continue;
      const S value = i < 3 ? r(i) : i < kExtrinsicColumns ? dp(i - 3) : lens_entry(now, i) - lens_entry(given, i);
      fold_prior_row<S>(R, at.camera + at.per_camera * c + i, Vec3<S>(S(1), S(0), S(0)), value, sigma, row);
    }
  }
}

/// Prior of the first state. Place and heading are held: nothing measures them.
template <class S>
void fold_start_prior(const VioOptions<S>& options, const State<S>& x0, PackedTriangle<S>* R, const StartColumns& at,
                      S sigma_v, S sigma_b_a, S* row) {
  const Mat3<S> unit = Mat3<S>::Identity();
  for (int i = 0; i < 3; ++i) {
    const Vec3<S> error_in_G = x0.R_GI.row(i).transpose();  // roll, pitch, yaw
    const Vec3<S> e = unit.col(i);
    fold_prior_row<S>(R, at.theta, error_in_G, S(0), i == 2 ? S(1e-3) : S(0.5), row);
    fold_prior_row<S>(R, at.p, e, S(0), S(1e-3), row);
    fold_prior_row<S>(R, at.motion, e, S(0), sigma_v, row);
    fold_prior_row<S>(R, at.motion + 3, e, x0.b_a(i), sigma_b_a, row);
    fold_prior_row<S>(R, at.motion + 6, e, x0.b_g(i), options.sigma_b_g, row);
  }
}

/// Cost and number of the window's image rows.
template <class S>
struct RefineFit {
  S cost = S(0);  ///< robust, in units of pixel_sigma
  int points = 0;
  int tracks = 0;
  int tried = 0;          ///< tracks long enough
  int good = 0;           ///< tracks whose residuals are about what pixel_sigma says
  std::int32_t work = 0;  ///< points linearised since the last pause
};

/// Two rows [l 3 | x0 15 | cameras | rhs] of an image point, n numbers beside the landmark's and the right-hand side;
/// the camera's `columns` ones begin at `first`.
template <class S>
void write_rows(const ReprojectionRows<S>& rows, const Mat<S, 2, kStateColumns>& J, int first, int columns, S weight,
                int n, S* out) {
  const int stride = kLandmarkColumns + n + 1;
  for (int k = 0; k < 2; ++k) {
    S* row = out + k * stride;
    for (int c = 0; c < stride; ++c) row[c] = S(0);
    for (int c = 0; c < kLandmarkColumns; ++c) row[c] = weight * rows.J_l(k, c);
    for (int c = 0; c < kStateColumns; ++c) row[3 + c] = weight * J(k, c);
    for (int c = 0; c < columns; ++c) row[3 + first + c] = weight * rows.J_camera(k, c);
    row[3 + n] = -weight * rows.r(k);
  }
}

/// px. White noise and walk taken together as white: over the window a walk scatters about its mean by q T / 6.
template <class S>
S start_pixel_sigma(const Window<S>& w, const VioOptions<S>& options) {
  if (!kTrackWalk) return options.pixel_sigma;
  const S T = S(w.newest().time - w.pose[0].time) * S(1e-9);
  return options.pixel_sigma * square_root(S(1) + options.walk_variance() * T / S(6));
}

/// One track's rows [l 3 | x0 15 | cameras | rhs] into the
/// triangle, Huber weights beyond 2 sigma. *rho: triangulate_again().
template <class S>
void refine_track(Window<S>* w, const VioTrack<S>& track, const VioOptions<S>& options, const StartScratch<S>& s,
                  PackedTriangle<S>* R, RefineFit<S>* fit, S* rho) {
  const TrackView<S> view = view_of(*w, track);
  if (view.n < 4) return;
  fit->points += view.n;
  ++fit->tried;
  Landmark<S> l;
  const int n = R->columns() - 1, stride = kLandmarkColumns + n + 1;
  const CameraCalibration<S>& camera = w->theta.camera[track.camera];
  const int columns = columns_per_camera(*w, *R), first = kStateColumns + columns * track.camera;
  const S sigma = start_pixel_sigma(*w, options);
  S cost = S(0);
  bool good = triangulate_again(*w, view, S(4) * sigma, w->block, &l, rho, &fit->work);
  fit->work += 2 * view.n;  // its rows, and their fold
  for (int i = 0; good && i < view.n; ++i) {
    const WindowPose<S>& pose = w->pose[view.pose[i]];
    ReprojectionRows<S> rows;
    good = reprojection_rows(camera, pose.R_GI, pose.p_GI, pose.R_GI, pose.p_GI, l, view.uv(*w, i), &rows);
    if (!good) break;
    const S e = square_root(rows.r.squaredNorm()) / sigma;
    cost += e < S(2) ? e * e : S(4) * e - S(4);
    const S weight = (e < S(2) ? S(1) : square_root(S(2) / e)) / sigma;
    Mat<S, 6, kStateColumns> D;
    pose_by_start(s.x0, s.link[view.pose[i]], &D);
    write_rows<S>(rows, rows.J_pose * D, first, columns, weight, n, w->block + 2 * i * stride);
  }
  const S worst = S(20) * S(view.n);  // a track that fits nowhere costs this much and pulls at nothing
  if (!good || cost > worst) {
    fit->cost += worst;
    return;
  }
  fit->cost += cost;
  ++fit->tracks;
  if (cost < S(2.5) * S(2 * view.n - 3)) ++fit->good;
  reflect_leading_columns(w->block, 2 * view.n, stride, stride, kLandmarkColumns);
  fold_rows(*R, w->block + 3 * stride + 3, 2 * view.n - 3, stride, 0, n);
}

/// m/s^2. Over a second, in which a device turns little, scale, misalignment and rotation of the accelerometer are a
/// bias as well: what they make of gravity.
template <class S>
S start_bias_sigma(const VioOptions<S>& options) {
  const S of_sensor = options.sigma_accel * options.sigma_accel + options.sigma_r_AI * options.sigma_r_AI;
  return square_root(options.sigma_b_a * options.sigma_b_a + options.g.squaredNorm() * of_sensor);
}

/// Poses and priors at s.x0 and the present cameras; the tracks' rows follow one by one (start_motion.h).
template <class S>
RefineFit<S> begin_linearisation(Window<S>* w, const VioOptions<S>& options, const StartScratch<S>& s,
                                 PackedTriangle<S>* R) {
  place_poses(w, options, s);
  R->clear();
  const StartColumns at{0, 3, 6, kStateColumns, columns_per_camera(*w, *R)};
  fold_start_prior(options, s.x0, R, at, S(3), start_bias_sigma(options), w->block);
  fold_camera_prior(*w, options, R, at, w->block);
  RefineFit<S> fit;
  const int n = R->columns() - 1;
  for (int j = 0; j < n; ++j) fit.cost += (*R)(j, n) * (*R)(j, n);
  return fit;
}

/// The damped step: R with lambda times each column's squared norm added, in `damped`.
template <class S>
void damped_step(const PackedTriangle<S>& R, S lambda, S* damped_data, S* row, S* step) {
  const int n = R.columns() - 1;
  PackedTriangle<S> damped(damped_data, n + 1);
  for (int j = 0; j <= n; ++j) {
    for (int c = j; c <= n; ++c) damped.row(j)[c] = R(j, c);
  }
  for (int j = 0; j < n; ++j) {
    S norm2 = S(0);
    for (int k = 0; k <= j; ++k) norm2 += R(k, j) * R(k, j);
    for (int c = 0; c <= n; ++c) row[c] = S(0);
    row[j] = square_root(lambda * norm2);
    fold_rows(damped, row, 1, n + 1, j, n);
  }
  for (int j = 0; j < n; ++j) step[j] = damped(j, n);
  back_substitute(damped, n, step);
}

/// Moves x0 and the cameras by a step.
template <class S>
void take_start_step(Window<S>* w, const S* step, int per_camera, StartScratch<S>* s) {
  s->x0.add(step);
  for (int c = 0; c < w->theta.n_cameras; ++c) {
    S of_camera[kMaxCameraColumns] = {};
    for (int i = 0; i < per_camera; ++i) of_camera[i] = step[kStateColumns + per_camera * c + i];
    add_camera_step(&w->theta.camera[c], of_camera);
  }
}

/// One damped step from the linearisation in R.
template <class S>
void descend(Window<S>* w, const PackedTriangle<S>& R, S lambda, StartScratch<S>* s) {
  S step[kRefineColumns];
  damped_step(R, lambda, w->triangle + packed_size(kRefineColumns + 1), w->block, step);
  take_start_step(w, step, columns_per_camera(*w, R), s);
}

/// A track that does not fit the refined window is a mismatch or
/// a thing that moves: it is not to be offered to the filter.
template <class S>
bool misfit(Window<S>* w, const VioTrack<S>& track, const VioOptions<S>& options, S pixel_scale) {
  const S sigma = start_pixel_sigma(*w, options) * pixel_scale;
  const TrackView<S> view = view_of(*w, track);
  if (!track.used || view.n < kMinTrackLength) return false;
  Landmark<S> l;
  S cost = S(0);
  bool good = triangulate(*w, view, S(4) * sigma, w->block, &l);
  for (int i = 0; good && i < view.n; ++i) {
    const WindowPose<S>& pose = w->pose[view.pose[i]];
    Vec2<S> r;
    good = reprojection_residual(w->theta.camera[track.camera], pose.R_GI, pose.p_GI, l, view.uv(*w, i), &r);
    if (good) cost += r.squaredNorm();
  }
  return !(good && cost < S(2) * sigma * sigma * chi_square_gate<S>(2 * view.n - 3));
}

}  // namespace SEGCAL_NS
