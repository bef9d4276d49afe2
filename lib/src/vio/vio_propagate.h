// Time moves on: a new state enters through the inertial link, the old motion (velocity, biases) leaves, and
// at the far end of the window the oldest pose leaves.
#pragma once

#include "sensors/roughness.h"
#include "vio/readings.h"
#include "vio/window_update.h"

namespace SEGCAL_NS {

/// The state that the integral predicts; biases stay.
template <class S>
State<S> predicted(const ImuIntegral<S>& I, const State<S>& x0, const Vec3<S>& g) {
  State<S> x1 = x0;
  x1.R_GI = renormalised<S>(x0.R_GI * I.dR);
  x1.v_GI = x0.v_GI + g * I.dt + x0.R_GI * I.dv;
  x1.p_GI = x0.p_GI + x0.v_GI * I.dt + g * (I.dt * I.dt / S(2)) + x0.R_GI * I.dp;
  return x1;
}

/// Integrates [t0, t1] of the history at the biases of `x0`, with the noise that the readings
/// show. Terms of the IMU that theta has are taken off here; of the camera's, a time offset
/// is in the stamps already, and what else moves image points is left to the filter's own
/// estimates of the lens. Inlined, so that its integrator shares the caller's stack.
template <class S>
[[gnu::always_inline]] inline ImuIntegral<S> integral_between(const Window<S>& w, const VioOptions<S>& options,
                                                              const ImuHistory<S>& imu, const State<S>& x0,
                                                              std::int64_t t0, std::int64_t t1) {
  const ImuStretch<S> samples(imu, 0, imu.newest(), imu.warmth());
  ImuIntegrator<S> integrator(w.theta.imu, x0.b_a, x0.b_g, noise_in(samples, options.noise, t0, t1, S(1e-9)),
                              &w.theta.effects);
  samples.integrate(t0, t1, x0.R_GI, &integrator);
  return integrator.result();
}

/// Copies one column group of the link's Jacobian into its place in the block.
template <class S>
void place_columns(const Window<S>& w, S* row, int i, int from, int to, int n) {
  const ImuRows<S>& link = w.link();
  for (int c = 0; c < n; ++c) row[to + c] += link.J(i, from + c);
}

/// Rows [from, to) of the whitened link into the block from row
/// `row` on; R's columns from the poses on stand one motion later.
template <class S>
void place_link(Window<S>* w, int from, int to, int row, int old_motion, int new_motion, int old_pose, int new_pose) {
  for (int i = from; i < to; ++i) {
    S* out = w->block + (row + i - from) * kBlockStride;
    place_columns(*w, out, i, kPoseColumns, old_motion, kMotionColumns);
    place_columns(*w, out, i, kStateColumns + kPoseColumns, new_motion, kMotionColumns);
    place_columns(*w, out, i, 0, kMotionColumns + pose_column(old_pose), kPoseColumns);
    place_columns(*w, out, i, kStateColumns, kMotionColumns + pose_column(new_pose), kPoseColumns);
    place_columns(*w, out, i, 2 * kStateColumns, kMotionColumns + w->imu_column(), kImuColumns);
    out[kMotionColumns + w->columns()] = -w->link().r(i);
  }
}

/// The block that carries the old motion away: rows of R that hold it, then those of the whitened link.
/// Columns: [old motion 9 | new motion 9 | R's columns from the poses on].
template <class S>
void stack_motion(Window<S>* w) {
  w->clear_block(kMotionColumns);
  PackedTriangle<S> R = w->R();
  const int n = w->columns();
  for (int j = 0; j < kMotionColumns; ++j) {
    S* row = w->block + j * kBlockStride;
    for (int c = j; c < kMotionColumns; ++c) row[c] = R(j, c);
    for (int c = kMotionColumns; c <= n; ++c) row[kMotionColumns + c] = R(j, c);
    for (int c = j; c <= n; ++c) R.row(j)[c] = S(0);
  }
}

/// Where reduce_link() leaves its rows.
template <class S>
S* link_rows_in(Window<S>* w) {
  return w->block + kMotionColumns * kBlockStride + kMotionColumns;
}

/// After stack_motion(): as many of the link's rows from row `from` on as the block has room for, with the old motion
/// eliminated. They are to be folded; returns their number.
template <class S>
int reduce_link(Window<S>* w, int from, int old_pose, int new_pose) {
  const int m = kLinkRows - from < kRowsAtATime ? kLinkRows - from : kRowsAtATime,
            width = w->columns() + 1 + kMotionColumns;
  S* rows = w->block + kMotionColumns * kBlockStride;
  for (int c = 0; c < m * kBlockStride; ++c) rows[c] = S(0);
  place_link(w, from, from + m, kMotionColumns, 0, kMotionColumns, old_pose, new_pose);
  for (int j = 0; j < kMotionColumns; ++j) reflect_column(w->block + j * kBlockStride, rows, m, kBlockStride, j, width);
  return m;
}

template <class S>
void fold_link(Window<S>* w, int old_pose, int new_pose) {
  stack_motion(w);
  for (int from = 0; from < kLinkRows;) {
    const int m = reduce_link(w, from, old_pose, new_pose);
    fold_block(w, link_rows_in(w), m, 0);
    from += m;
  }
}

/// Whitened link rows between the newest state and `x1`; Jacobians at first estimates, x1's at `first`. False: no
/// duration. What is not estimated of the IMU has no column.
template <class S>
bool linearise_link(Window<S>* w, const VioOptions<S>& options, const ImuIntegral<S>& I, const State<S>& x1,
                    const State<S>& first) {
  ImuRows<S>& link = w->links.template begin<ImuRows<S>>();
  link_rows<S>(I, w->now, x1, w->now_first, first, options.g, &link);
  for (int i = 0; i < kImuColumns; ++i) {
    if (imu_sigma(options, i) == S(0)) link.J.col(2 * kStateColumns + i).setZero();
  }
  return whiten(I, options.noise, &link);
}

/// Appends the state at t1, predicted from the newest one by the integral up to there. Returns the new pose's slot.
template <class S>
int propagate(Window<S>* w, const VioOptions<S>& options, const ImuIntegral<S>& I, std::int64_t t1) {
  const State<S> x1 = predicted(I, w->now, options.g);
  if (!linearise_link(w, options, I, x1, x1)) return w->newest().slot;
  w->link().r.setZero();  // the prediction is exact; only rounding would remain
  const int slot = w->append_empty(t1);
  WindowPose<S>& pose = w->newest();
  pose.R_GI = pose.R_first = x1.R_GI;
  pose.p_GI = pose.p_first = x1.p_GI;
  fold_link(w, w->n_poses - 2, w->n_poses - 1);
  w->now = w->now_first = x1;
  return slot;
}

/// Rows of R below the first 15 move up-left by one pose: the place of the last pose becomes free.
template <class S>
void close_gap(Window<S>* w) {
  PackedTriangle<S> R = w->R();
  const int n = w->columns(), last = pose_column(kWindow - 1), cameras = camera_column(0);
  for (int j = kMotionColumns; j < last; ++j) {
    for (int c = j; c < last; ++c) R.row(j)[c] = R(j + kPoseColumns, c + kPoseColumns);
    for (int c = last; c < cameras; ++c) R.row(j)[c] = S(0);
    for (int c = cameras; c <= n; ++c) R.row(j)[c] = R(j + kPoseColumns, c);
  }
  for (int j = last; j < cameras; ++j) {
    for (int c = j; c <= n; ++c) R.row(j)[c] = S(0);
  }
}

/// Marginalises pose 0: in the first 15 rows its columns are put in front and eliminated.
template <class S>
void drop_oldest(Window<S>* w) {
  constexpr int rows = kMotionColumns + kPoseColumns;
  PackedTriangle<S> R = w->R();
  const int n = w->columns(), last = pose_column(kWindow - 1), cameras = camera_column(0);
  w->clear_block(rows);
  for (int j = 0; j < rows; ++j) {
    S* row = w->block + j * kBlockStride;
    for (int c = j; c < kMotionColumns; ++c) row[kPoseColumns + c] = R(j, c);
    for (int c = j > kMotionColumns ? j : kMotionColumns; c < rows; ++c) row[c - kMotionColumns] = R(j, c);
    for (int c = rows; c <= n; ++c) row[c] = R(j, c);
  }
  reflect_leading_columns(w->block, rows, kBlockStride, n + 1, rows);
  close_gap(w);
  for (int j = 0; j < kMotionColumns; ++j) {
    const S* row = w->block + (kPoseColumns + j) * kBlockStride + kPoseColumns;  // columns counted after the pose
    for (int c = j; c < last; ++c) R.row(j)[c] = row[c];
    for (int c = last; c < cameras; ++c) R.row(j)[c] = S(0);
    for (int c = cameras; c <= n; ++c) R.row(j)[c] = row[c - kPoseColumns];
  }
  w->forget_oldest();
}

}  // namespace SEGCAL_NS
