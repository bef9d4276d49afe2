// The IMU links of a segment, eliminated in time order (DESIGN, section 4, step 2).
//
// A link touches two neighbouring keyframes, so a small triangle over
// [keyframe k 15 | keyframe k + 1 15 | guest 15 | IMU part of theta 15 | -r] is enough: each step folds 15 rows, hands
// out the 15 finished rows of keyframe k and moves on. "Guest" is the last keyframe of the segment before, where the two
// are joined by their IMU link or by the bias walk over a gap.
#pragma once

#include "segments/segment.h"
#include "segments/weights.h"

namespace SEGCAL_NS {

constexpr int kGuestColumn = 2 * kStateColumns;
constexpr int kChainImuColumn = 3 * kStateColumns;
constexpr int kChainColumns = kChainImuColumn + kImuColumns + 1;

template <class S>
class InertialChain {
 public:
  void begin() {
    triangle().clear();
    rows_ = 0;
  }
  /// Residuals folded so far.
  int rows() const { return rows_; }
  PackedTriangle<S> triangle() { return PackedTriangle<S>(data_, kChainColumns); }

  /// A row that touches one column of the current keyframe or of the guest: weight (x - target) with rhs = -residual.
  void add_scalar(int column, S weight, S rhs) {
    clear_block(1);
    block_[column] = weight;
    block_[kChainColumns - 1] = rhs;
    fold(1, column);
  }

  /// A row over three columns of the current keyframe's rotation (the gauge's yaw).
  void add_rotation_row(const Vec3<S>& direction, S weight) {
    clear_block(1);
    for (int i = 0; i < 3; ++i) block_[i] = weight * direction(i);
    fold(1, 0);
  }

  /// Bias walk from the guest to the current keyframe.
  void add_bias_link(const Vec3<S>& d_ba, const Vec3<S>& d_bg, S weight_a, S weight_g) {
    for (int i = 0; i < 6; ++i) {
      const S w = i < 3 ? weight_a : weight_g;
      clear_block(1);
      block_[9 + i] = w;
      block_[kGuestColumn + 9 + i] = -w;
      block_[kChainColumns - 1] = -w * (i < 3 ? d_ba(i) : d_bg(i - 3));
      fold(1, 9 + i);
    }
    rows_ += 6;
  }

  /// Link from the guest to the current keyframe.
  void add_guest_link(const ImuRows<S>& rows) { add_link(rows, kGuestColumn, 0, 0); }
  /// Link from the current keyframe to the next one.
  void add_next_link(const ImuRows<S>& rows) { add_link(rows, 0, kStateColumns, 0); }

  /// The next keyframe becomes the current one; its rows so far move along.
  void advance() {
    PackedTriangle<S> R = triangle();
    for (int i = 0; i < kStateColumns; ++i) {
      const S* from = R.row(kStateColumns + i);
      S* to = R.row(i);
      for (int c = i; c < kStateColumns; ++c) to[c] = from[kStateColumns + c];
      for (int c = kStateColumns; c < kGuestColumn; ++c) to[c] = S(0);
      for (int c = kGuestColumn; c < kChainColumns; ++c) to[c] = from[c];
    }
    for (int i = kStateColumns; i < kGuestColumn; ++i) {
      S* r = R.row(i);
      for (int c = i; c < kChainColumns; ++c) r[c] = S(0);
    }
  }

 private:
  void clear_block(int rows) {
    for (int c = 0; c < rows * kChainColumns; ++c) block_[c] = S(0);
  }
  void fold(int rows, int first) {
    PackedTriangle<S> R = triangle();
    fold_rows(R, block_, rows, kChainColumns, first, kChainColumns, work_);
  }
  void add_link(const ImuRows<S>& rows, int column0, int column1, int first) {
    clear_block(15);
    for (int i = 0; i < 15; ++i) {
      S* r = block_ + i * kChainColumns;
      for (int c = 0; c < kStateColumns; ++c) {
        r[column0 + c] = rows.J(i, c);
        r[column1 + c] = rows.J(i, kStateColumns + c);
      }
      for (int c = 0; c < kImuColumns; ++c) r[kChainImuColumn + c] = rows.J(i, 2 * kStateColumns + c);
      r[kChainColumns - 1] = -rows.r(i);
    }
    fold(15, first);
    rows_ += 15;
  }

  int rows_ = 0;
  S data_[packed_size(kChainColumns)];
  S block_[15 * kChainColumns];
  S work_[kChainColumns];
};

}  // namespace SEGCAL_NS
