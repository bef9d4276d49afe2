// What is measured goes into the window's information, and the estimates move.
#pragma once

#include "math/qr.h"
#include "math/small_solvers.h"
#include "vio/vio_window.h"

namespace SEGCAL_NS {

/// Folds `rows` rows of the block (absolute columns, zero before `first`) into R.
/// Returns the squared norm of what R cannot absorb: the innovation's Mahalanobis distance if d was zero.
template <class S>
S fold_block(Window<S>* w, S* rows, int n_rows, int first) {
  const int n = w->columns();
  fold_columns(w, rows, n_rows, first, n);
  return left_over(w, rows, n_rows);
}

/// Squared norm of what R did not absorb of the rows.
template <class S>
S left_over(const Window<S>* w, const S* rows, int n_rows) {
  const int n = w->columns();
  S rest = S(0);
  for (int i = 0; i < n_rows; ++i) rest += rows[i * kBlockStride + n] * rows[i * kBlockStride + n];
  return rest;
}

/// The fold's part of columns [first, last).
template <class S>
void fold_columns(Window<S>* w, S* rows, int n_rows, int first, int last) {
  PackedTriangle<S> R = w->R();
  for (int j = first; j < last; ++j) w->pivot[j] = R(j, j);
  fold_rows(R, rows, n_rows, kBlockStride, first, last);
}

/// Takes the last fold_block() back: the same reflections in reverse order, each its
/// own inverse (up to rounding). Their vectors are still there: reflect_column()
/// leaves the column that it clears in the block, and `pivot` has the rest.
template <class S>
void unfold_block(Window<S>* w, S* rows, int n_rows, int first) {
  unfold_columns(w, rows, n_rows, first, w->columns());
}

/// Of columns [first, last), the last first.
template <class S>
void unfold_columns(Window<S>* w, S* rows, int n_rows, int first, int last) {
  PackedTriangle<S> R = w->R();
  for (int j = last - 1; j >= first; --j) {
    S* r = R.row(j);
    if (square_sum(rows + j, n_rows, kBlockStride) < smallest_square<S>) continue;  // as reflect_column() found
    const S v0 = w->pivot[j] - r[j];
    reflect_range(Reflection<S>{r, rows, n_rows, kBlockStride, j, v0, S(-1) / (r[j] * v0)}, j + 1, R.columns());
    r[j] = w->pivot[j];
  }
}

/// Moves all estimates by R^-1 d; afterwards d is zero. First estimates stay.
template <class S>
void apply_update(Window<S>* w) {
  PackedTriangle<S> R = w->R();
  const int n = w->columns();
  S* d = w->block;
  for (int j = 0; j < n; ++j) {
    d[j] = R(j, n);
    R.row(j)[n] = S(0);
  }
  R.row(n)[n] = S(0);
  back_substitute(R, n, d);
  const auto three = [d](int c) { return Vec3<S>(d[c], d[c + 1], d[c + 2]); };
  for (int i = 0; i < w->n_poses; ++i) {
    WindowPose<S>& pose = w->pose[i];
    pose.R_GI = renormalised<S>(pose.R_GI * so3_exp<S>(three(pose_column(i))));
    pose.p_GI += three(pose_column(i) + 3);
  }
  w->now.R_GI = w->newest().R_GI;
  w->now.p_GI = w->newest().p_GI;
  w->now.v_GI += three(0);
  w->now.b_a += three(3);
  w->now.b_g += three(6);
  for (int c = 0; c < w->theta.n_cameras; ++c) {
    CameraCalibration<S>& camera = w->theta.camera[c];
    camera.R_CI = renormalised<S>(so3_exp<S>(three(camera_column(c))) * camera.R_CI);
    camera.p_CI += three(camera_column(c) + 3);
    for (int i = 0; i < 4; ++i) camera.intrinsics(i) += d[camera_column(c) + kExtrinsicColumns + i];
    for (int i = 0; i < 4; ++i) camera.distortion(i) += d[camera_column(c) + kExtrinsicColumns + 4 + i];
  }
  ImuCalibration<S>& imu = w->theta.imu;
  const int first = w->imu_column();
  imu.gyro_scale += three(first);
  imu.gyro_misalignment += three(first + 3);
  imu.accel_scale += three(first + 6);
  imu.accel_misalignment += three(first + 9);
  imu.R_AI = renormalised<S>(so3_exp<S>(three(first + 12)) * imu.R_AI);
}

}  // namespace SEGCAL_NS
