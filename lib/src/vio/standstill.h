// Standing still: no new pose, no drift.
//
// While the IMU is quiet and the image does not move, the newest pose simply stays the newest pose: the window keeps
// its baseline, and the inertial link from the pose to itself tells biases and gravity. Image motion is measured
// against the frame in which the pose was last added, so a slow drift adds up and ends the standstill.
//
// A thing on its legs may also rock: it has been put down, or motors shake it. It turns by some milliradians, and what
// is near moves in the image, but its place stays. Then poses are added as in motion, with the image's word that they
// are at the same place: without it the filter, which has no baseline any more, only integrates a shaken accelerometer.
#pragma once

#include "math/quantiles.h"
#include "math/small_solvers.h"
#include "vio/image_motion.h"
#include "vio/vio_propagate.h"
#include "vio/vio_tracks.h"

namespace SEGCAL_NS {

/// The test with what it looks at.
template <class S>
struct StillTest {
  const VioOptions<S>& options;
  const Window<S>& window;
  const TrackTable<S>& tracks;
  const ImuHistory<S>& imu;

  /// How much the IMU shakes, in units of what rest allows. A hand that holds still for a tenth of a second is not a
  /// floor: look back a little further.
  S shaking(std::int64_t t1) const {
    const std::int64_t t0 = t1 - 300000000;
    if (!imu.covers(t0, t1)) return S(1e3);
    const ReadingSpread<S> spread = reading_spread(imu, t0, t1);
    if (spread.samples < 5) return S(1e3);
    const S gyro = spread.gyro / options.still_gyro, accel = spread.accel / options.still_accel;
    return gyro > accel ? gyro : accel;
  }

  /// No common motion between the frame of a pose and the points of the present one.
  bool image_stays(const WindowPose<S>& pose, const TrackPoint<S>* points, int n) const {
    RigMotion<S> motion;
    for (int i = 0; i < n; ++i) {
      const VioTrack<S>* track = tracks.find(points[i].id, points[i].camera);
      if (track && track->in(pose.slot)) motion.add(points[i].camera, track->uv[pose.slot], points[i].uv);
    }
    return motion.all([&](int, const ImageMotion<S>& camera) { return camera.none(options.still_pixels); });
  }

  /// The newest pose against a frame at t1. A quiet IMU and an image that stays since the last frame are enough. If the
  /// IMU shakes (touching down, motors that start) the image must have stayed for half a second; in a standstill it
  /// is compared with the frame in which that began anyway.
  bool still(std::int64_t t1, bool stands_already, const TrackPoint<S>* points, int n) const {
    if (window.now.v_GI.squaredNorm() > S(0.04)) return false;
    const S shakes = shaking(t1);
    if (!(shakes < S(25)) || !image_stays(window.newest(), points, n)) return false;
    if (shakes < S(1) || stands_already) return true;
    return window.n_poses >= 5 && image_stays(window.pose[window.n_poses - 5], points, n);
  }

  /// Once the turning (R_GI: the present attitude) is taken out, is the image that of a pose at the same place?
  bool same_place(const WindowPose<S>& pose, const Mat3<S>& R_GI, S nearness, const TrackPoint<S>* points,
                  int n) const {
    const Mat3<S> R_turn = R_GI.transpose() * pose.R_GI;
    RigMotion<S> motion;
    Vec2<S> expected;
    for (int i = 0; i < n; ++i) {
      const VioTrack<S>* track = tracks.find(points[i].id, points[i].camera);
      if (!track || !track->in(pose.slot)) continue;
      const CameraCalibration<S>& camera = window.theta.camera[points[i].camera];
      if (turned_point(camera, R_turn, track->uv[pose.slot], &expected)) {
        motion.add(points[i].camera, expected, points[i].uv);
      }
    }
    const S share = options.still_metres * nearness;
    return motion.all([&](int c, const ImageMotion<S>& camera) {
      const S focal = window.theta.camera[c].intrinsics(0), most = S(1.5) / focal;
      return camera.no_translation(share < most ? share : most, focal);
    });
  }

  /// The pose of the window whose place the device has not left, or -1. Three frames back tell slow motion from none;
  /// the farther back the better: `frames` is how long it has been so.
  int place_kept(const Mat3<S>& R_GI, S nearness, int frames, const TrackPoint<S>* points, int n) const {
    const int recent = window.n_poses - 3, oldest = recent - frames;
    if (recent < 0 || !(window.now.v_GI.squaredNorm() < S(0.04))) return -1;
    if (!same_place(window.pose[recent], R_GI, nearness, points, n)) return -1;
    if (frames > 0 && oldest >= 0 && same_place(window.pose[oldest], R_GI, nearness, points, n)) return oldest;
    return recent;
  }

  /// Rest beyond doubt, whatever the filter believes: the IMU is quiet and the image has stayed for half a second.
  bool rests(std::int64_t t1, const TrackPoint<S>* points, int n) const {
    return shaking(t1) < S(1) && window.n_poses >= 5 && image_stays(window.newest(), points, n) &&
           image_stays(window.pose[window.n_poses - 5], points, n);
  }
};

/// Three rows of weight 1/sigma on columns [column, column + 3) with right-hand side -value/sigma: a measurement of 0.
template <class S>
void zero_rows(S* rows, int column, int rhs, const Vec3<S>& value, S sigma) {
  for (int i = 0; i < 3; ++i) {
    rows[i * kBlockStride + column + i] = S(1) / sigma;
    rows[i * kBlockStride + rhs] = -value(i) / sigma;
  }
}

template <class S>
void fold_zero(Window<S>* w, int column, const Vec3<S>& value, S sigma) {
  w->clear_block(3);
  zero_rows(w->block, column, w->columns(), value, sigma);
  fold_block(w, w->block, 3, column);
}

/// The newest pose is where pose `reference` is, as far as the image can
/// tell. False, and nothing changed, if the filter does not believe it.
template <class S>
bool hold_place(Window<S>* w, int reference, S sigma) {
  const int newest = w->n_poses - 1, first = pose_column(reference);
  w->clear_block(3);
  zero_rows(w->block, pose_column(newest) + 3, w->columns(), Vec3<S>(w->now.p_GI - w->pose[reference].p_GI), sigma);
  for (int i = 0; i < 3; ++i) w->block[i * kBlockStride + first + 3 + i] = S(-1) / sigma;
  if (!(fold_block(w, w->block, 3, first) < chi_square_gate<S>(3))) {
    unfold_block(w, w->block, 3, first);
    return false;
  }
  apply_update(w);
  return true;
}

/// Mahalanobis distance of a standstill link (whitened, w->link()) with zero velocity after it: the new motion is
/// eliminated, y = R^-T h for each of the nine rows h that are left, and y y' + 1 is the covariance of the innovations.
template <class S>
S still_distance(Window<S>* w, S sigma_v) {
  constexpr int rows = kLinkRows + 3, dof = rows - kMotionColumns;
  const int newest = w->n_poses - 1, n = w->columns();
  w->clear_block(rows);
  place_link(w, 0, kLinkRows, 0, kMotionColumns, 0, newest, newest);
  zero_rows(w->block + kLinkRows * kBlockStride, 0, kMotionColumns + n, w->now.v_GI, sigma_v);
  reflect_leading_columns(w->block, rows, kBlockStride, n + 1 + kMotionColumns, kMotionColumns);
  Mat<S, dof, dof> C, L;
  Vec<S, dof> z;
  S distance = S(0);
  for (int i = 0; i < dof; ++i) {
    S* y = w->block + (kMotionColumns + i) * kBlockStride + kMotionColumns;
    forward_substitute(w->R(), n, 0, y);
    for (int k = 0; k <= i; ++k) {
      C(i, k) = C(k, i) = factor_product(y, w->block + (kMotionColumns + k) * kBlockStride + kMotionColumns, n);
    }
    C(i, i) += S(1);
    z(i) = y[n];
  }
  if (!cholesky_lower<S, dof>(C, &L)) return S(2) * chi_square_gate<S>(dof);
  forward_substitute<S, dof>(L, z.data());
  for (int i = 0; i < dof; ++i) distance += z(i) * z(i);
  return distance;
}

/// The newest state moves on to t1 without moving: same pose, velocity zero. What a thing on a floor may do between
/// two frames is added to the link's noise, more if it shakes.
/// False, and nothing changed, if the filter does not believe it.
template <class S>
bool propagate_still(Window<S>* w, const VioOptions<S>& options, ImuIntegral<S> I, S shaking) {
  const S more = shaking < S(1) ? S(1) : S(2) * shaking;
  for (int i = 0; i < 3; ++i) {
    I.P(i, i) += more * more * S(2.5e-7);          // 0.5 mrad
    I.P(3 + i, 3 + i) += more * more * S(2.5e-5);  // 5 mm/s
    I.P(6 + i, 6 + i) += more * more * S(2.5e-7);  // 0.5 mm
  }
  if (!linearise_link(w, options, I, w->now, w->now_first)) return false;
  if (!(still_distance(w, more * options.still_velocity_sigma) < chi_square_gate<S>(kMotionColumns))) return false;
  fold_link(w, w->n_poses - 1, w->n_poses - 1);
  fold_zero(w, 0, w->now.v_GI, more * options.still_velocity_sigma);
  w->now_first.v_GI = w->now.v_GI;
  w->now_first.b_a = w->now.b_a;
  w->now_first.b_g = w->now.b_g;
  apply_update(w);
  return true;
}

}  // namespace SEGCAL_NS
