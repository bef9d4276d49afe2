// The triangle that a segment is reduced to:
// [poses 6 (K - 1) | last keyframe 15 | guest 15, where joined | theta: IMU part, then cameras | rhs].
//
// Cameras stand last in theta, beside the right-hand side, so that the landmarks' rows leave one gap in the middle.
//
// Velocities and biases of all keyframes but the last are eliminated before (velocity_bias_chain.h): each of them touches
// its two neighbours only, so they never stand in this triangle, which is what keeps it small.
#pragma once

#include "math/qr.h"
#include "segments/segment.h"

namespace SEGCAL_NS {

constexpr int kVelocityBiasColumns = kStateColumns - kPoseColumns;
constexpr int kReducedColumns = kPoseColumns * (kMaxKeyframes - 1) + 2 * kStateColumns + kMaxTheta + 1;

/// Where things stand. The last keyframe's pose follows the other poses, so pose k is always at 6 k.
struct ReducedLayout {
  int keyframes = 0, guest_columns = 0, n_theta = 0;

  int pose(int k) const { return kPoseColumns * k; }
  int last() const { return pose(keyframes - 1); }
  int guest() const { return last() + kStateColumns; }
  int theta() const { return guest() + guest_columns; }
  int imu() const { return theta(); }
  int cameras() const { return theta() + kImuColumns; }
  int camera_columns() const { return n_theta - kImuColumns; }
  int rhs() const { return theta() + n_theta; }
  int width() const { return rhs() + 1; }
};

template <class S>
class ReducedSystem {
 public:
  void begin(const ReducedLayout& layout) {
    layout_ = layout;
    seen_poses_ = 0;
    R().clear();
  }
  const ReducedLayout& layout() const { return layout_; }
  PackedTriangle<S> R() { return PackedTriangle<S>(data_, layout_.width()); }

  /// Folds landmark rows: they touch the poses of keyframes first to last and cameras only, and the rows folded before
  /// touch no later poses than the latest so far. Cheap, if the landmarks that end early come first.
  void fold_visual(S* rows, int m, int stride, int first_keyframe, int last_keyframe) {
    PackedTriangle<S> triangle = R();
    if (layout_.pose(last_keyframe + 1) > seen_poses_) seen_poses_ = layout_.pose(last_keyframe + 1);
    const ColumnGap gap{seen_poses_, layout_.cameras()};
    fold_rows(triangle, rows, m, stride, layout_.pose(first_keyframe), layout_.width(), work_, gap);
  }

  /// Theta's part of row i (theta() + i), in theta's own order [cameras | IMU], with the right-hand side last.
  void theta_row(int i, S* out) { to_theta_order(R().row(layout_.theta() + i), i, out); }

  /// The same for any row: entries of theta before the i-th are taken as zero.
  void to_theta_order(const S* row, int i, S* out) const {
    for (int c = 0; c < layout_.n_theta; ++c) {
      const int from = c < layout_.camera_columns() ? kImuColumns + c : c - layout_.camera_columns();
      out[c] = from < i ? S(0) : row[layout_.theta() + from];
    }
    out[layout_.n_theta] = row[layout_.rhs()];
  }

  /// Folds rows that stand in this layout; columns before `first` are zero. Destroys them.
  void fold(S* rows, int m, int stride, int first) {
    PackedTriangle<S> triangle = R();
    fold_rows(triangle, rows, m, stride, first, layout_.width(), work_);
  }
  /// One row with a single entry and its right-hand side.
  void fold_scalar(int column, S weight, S rhs) {
    clear_row();
    row_[column] = weight;
    row_[layout_.rhs()] = rhs;
    fold(row_, 1, kReducedColumns, column);
  }
  /// One row over the three rotation columns of pose k.
  void fold_rotation(int k, const Vec3<S>& direction, S weight) {
    clear_row();
    for (int i = 0; i < 3; ++i) row_[layout_.pose(k) + i] = weight * direction(i);
    fold(row_, 1, kReducedColumns, layout_.pose(k));
  }

  /// x[j] for j < known, from x[known..rhs).
  void back_substitute(S* x, int known) {
    const PackedTriangle<S> triangle = R();
    const int n = layout_.rhs();
    for (int j = known - 1; j >= 0; --j) {
      const S* r = triangle.row(j);
      S sum = r[n];
      for (int c = j + 1; c < n; ++c) sum -= r[c] * x[c];
      x[j] = r[j] == S(0) ? S(0) : sum / r[j];
    }
  }

 private:
  void clear_row() {
    for (int c = 0; c < layout_.width(); ++c) row_[c] = S(0);
  }
  ReducedLayout layout_;
  int seen_poses_ = 0;  // columns of poses that landmark rows have touched, all those before the latest included
  S data_[packed_size(kReducedColumns)];
  S row_[kReducedColumns];
  S work_[kReducedColumns];
};

}  // namespace SEGCAL_NS
