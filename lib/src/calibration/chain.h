// Segments that follow each other in time form a chain: each is eliminated to its last keyframe (the separator), the
// separator of the segment before (its guest) and theta, and the chain passes separators on from left to right.
//
// For each segment a small triangle over [guest 15 | last 15 | theta | rhs] takes what came from the left and what the
// segment says; its first 15 rows are kept for back-substitution, the next 15 go on to the right, the rest is theta's.
#pragma once

#include "segments/elimination.h"

namespace SEGCAL_NS {

constexpr int kLinkColumns = 2 * kStateColumns + kMaxTheta + 1;

/// Rows of the guest, kept for back-substitution: guest = f(last, theta).
template <class S>
struct GuestRows {
  S row[kStateColumns * kLinkColumns];
};

template <class S>
class Chain {
 public:
  /// Starts a new chain.
  void begin(int n_theta) {
    n_theta_ = n_theta;
    link().clear();
  }

  /// Takes segment i, just eliminated. `passes_on`: a later segment hangs on its last keyframe.
  /// `theta` gathers all rows that touch theta only.
  void add(SegmentEliminator<S>* segment, bool has_guest, bool passes_on, GuestRows<S>* kept, PackedTriangle<S>* theta) {
    // What came from the left stands in the rows of "last" of the segment before: its separator is our guest.
    take_from_left();
    const ReducedLayout& at = segment->layout();
    if (passes_on) fold_segment_rows(segment, at.last(), kStateColumns);
    if (has_guest) fold_segment_rows(segment, at.guest(), 0);
    if (has_guest) keep(kept);
    fold_theta(segment, theta);
    if (!passes_on) link().clear();
  }

  /// Step of the guest for known steps of the last keyframe (zero if it was not passed on) and theta.
  static void solve_guest(const GuestRows<S>& kept, int n_theta, const S* last_step, const S* theta_step, S* guest_step) {
    const int n = 2 * kStateColumns + n_theta;
    for (int i = kStateColumns - 1; i >= 0; --i) {
      const S* r = kept.row + i * (n + 1);
      S sum = r[n];
      for (int c = 0; c < n_theta; ++c) sum -= r[2 * kStateColumns + c] * theta_step[c];
      for (int c = 0; c < kStateColumns; ++c) sum -= r[kStateColumns + c] * last_step[c];
      for (int c = i + 1; c < kStateColumns; ++c) sum -= r[c] * guest_step[c];
      guest_step[i] = r[i] == S(0) ? S(0) : sum / r[i];
    }
  }

 private:
  int width() const { return 2 * kStateColumns + n_theta_ + 1; }
  PackedTriangle<S> link() { return PackedTriangle<S>(link_, width()); }

  void take_from_left() {
    PackedTriangle<S> L = link();
    for (int i = 0; i < kStateColumns; ++i) {
      const S* from = L.row(kStateColumns + i);
      S* to = L.row(i);
      for (int c = i; c < kStateColumns; ++c) to[c] = from[kStateColumns + c];
      for (int c = kStateColumns; c < 2 * kStateColumns; ++c) to[c] = S(0);
      for (int c = 2 * kStateColumns; c < width(); ++c) to[c] = from[c];
    }
    for (int i = kStateColumns; i < width(); ++i) {
      S* r = L.row(i);
      for (int c = i; c < width(); ++c) r[c] = S(0);
    }
  }

  /// Folds 15 rows of the segment's R that begin at column `from`; they stand at column `to` of the link triangle.
  void fold_segment_rows(SegmentEliminator<S>* segment, int from, int to) {
    PackedTriangle<S> R = segment->reduced().R(), L = link();
    const int guest = segment->layout().guest(), theta = segment->layout().theta();
    for (int i = 0; i < kStateColumns; ++i) {
      const S* r = R.row(from + i);
      for (int c = 0; c < width(); ++c) block_[c] = S(0);
      for (int c = i; c < kStateColumns; ++c) block_[to + c] = r[from + c];
      if (from != guest) {
        for (int c = guest; c < theta; ++c) block_[c - guest] = r[c];
      }
      segment->reduced().to_theta_order(r, 0, block_ + 2 * kStateColumns);
      fold_rows(L, block_, 1, width(), 0, width(), work_);
    }
  }

  void keep(GuestRows<S>* kept) {
    PackedTriangle<S> L = link();
    for (int i = 0; i < kStateColumns; ++i) {
      for (int c = i; c < width(); ++c) kept->row[i * width() + c] = L.row(i)[c];
    }
  }

  void fold_theta(SegmentEliminator<S>* segment, PackedTriangle<S>* theta) {
    PackedTriangle<S> L = link();
    for (int i = 0; i <= n_theta_; ++i) {
      segment->reduced().theta_row(i, block_);
      fold_rows(*theta, block_, 1, n_theta_ + 1, 0, n_theta_ + 1, work_);
      S* from_link = L.row(2 * kStateColumns + i) + 2 * kStateColumns;
      fold_theta_row(from_link, i, theta);
      for (int c = i; c <= n_theta_; ++c) from_link[c] = S(0);
    }
  }

  void fold_theta_row(const S* row, int first, PackedTriangle<S>* theta) {
    for (int c = 0; c <= n_theta_; ++c) block_[c] = c < first ? S(0) : row[c];
    fold_rows(*theta, block_, 1, n_theta_ + 1, first, n_theta_ + 1, work_);
  }

  int n_theta_ = 0;
  S link_[packed_size(kLinkColumns)];
  S block_[kLinkColumns];
  S work_[kLinkColumns];
};

}  // namespace SEGCAL_NS
