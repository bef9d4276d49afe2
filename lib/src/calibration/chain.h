// Segments that follow each other in time form a chain: each is eliminated to its last
// keyframe (the separator), the separator of the segment before (its guest) and the
// global columns (ties and theta), and the chain passes separators on from left to right.
//
// For each segment a small triangle over [guest 15 | last 15 | ties | theta | rhs] takes what came from the left and
// what the segment says; its first 15 rows give the guest, the next 15 go on to the right, and what is left of a row
// after these 30 is global: it goes on at once. For back-substitution only what came from the left is kept here: the
// segment's own triangle is there again then, kept (kept_eliminations.h) or made a second time.
#pragma once

#include "math/resumable.h"
#include "segments/elimination.h"

namespace SEGCAL_NS {

constexpr int kMaxGlobal = kTieColumns + kMaxWideTheta;
constexpr int kLinkColumns = 2 * kStateColumns + kMaxGlobal + 1;
constexpr int kLeftColumns = kStateColumns + kTieColumns + kMaxTheta + 1;

/// What the segments on the left say about the guest: 15 rows
/// over [guest | ties | theta | rhs], row i without its zeros.
template <class S>
struct LeftRows {
  S data[packed_size(kLeftColumns) - packed_size(kLeftColumns - kStateColumns)];
};

template <class S>
class Chain {
 public:
  /// Starts a new chain; `n_global`: ties and theta, with candidates.
  void begin(int n_global) {
    n_global_ = n_global;
    place_ = 0;
    clear_from(0);
  }

  /// What is known of the last keyframe of the segment that was
  /// taken last; a chain that was begun anew goes on with it.
  void hand_on(LeftRows<S>* rows) { copy_rows(kStateColumns, rows); }
  void go_on(const LeftRows<S>& rows) { take_rows(kStateColumns, rows); }

  /// Takes segment i, just eliminated. `passes_on`: a later segment hangs on its last keyframe. `left`: what
  /// solve_guest_step() will need; null: nobody will ask (with candidates it would not fit).
  /// `global` gathers all rows that touch ties and theta only. In slices; true when it is taken.
  [[gnu::cold]] bool add_step(SegmentEliminator<S>* segment, bool has_guest, bool passes_on, LeftRows<S>* left,
                              PackedTriangle<S>* global) {
    SEGCAL_SLICES(place_) {
      // What came from the left stands in the rows of "last" of the segment before: its separator is our guest.
      take_from_left();
      if (has_guest && left) keep(left);
      for (row_ = 0; passes_on && row_ < kStateColumns; ++row_) {
        fold_segment_row(segment, row_, segment->layout().last(), kStateColumns, global);
        if (row_ % kRowsPerSlice == kRowsPerSlice - 1) SEGCAL_PAUSE(place_);
      }
      for (row_ = 0; has_guest && row_ < kStateColumns; ++row_) {
        fold_segment_row(segment, row_, segment->layout().guest(), 0, global);
        if (row_ % kRowsPerSlice == kRowsPerSlice - 1) SEGCAL_PAUSE(place_);
      }
      for (row_ = 0; row_ <= segment->layout().global_columns(); ++row_) {
        fold_global(segment, row_, global);
        if (row_ % kRowsPerSlice == kRowsPerSlice - 1) SEGCAL_PAUSE(place_);
      }
      if (!passes_on) clear_from(0);
    }
    SEGCAL_SLICES_END(place_);
  }

  /// After add() of all segments: step of the guest of `segment`, just eliminated as it was then, for known steps of
  /// its last keyframe (zero if it was not passed on) and of ties and theta. In slices; true when it is known.
  [[gnu::cold]] bool solve_guest_step(SegmentEliminator<S>* segment, bool passes_on, const LeftRows<S>& left,
                                      const S* last_step, const S* global_step, S* guest_step) {
    SEGCAL_SLICES(place_) {
      restore(left);
      for (row_ = 0; passes_on && row_ < kStateColumns; ++row_) {
        fold_segment_row(segment, row_, segment->layout().last(), kStateColumns, nullptr);
        if (row_ % kRowsPerSlice == kRowsPerSlice - 1) SEGCAL_PAUSE(place_);
      }
      for (row_ = 0; row_ < kStateColumns; ++row_) {
        fold_segment_row(segment, row_, segment->layout().guest(), 0, nullptr);
        if (row_ % kRowsPerSlice == kRowsPerSlice - 1) SEGCAL_PAUSE(place_);
      }
      solve(last_step, global_step, guest_step);
    }
    SEGCAL_SLICES_END(place_);
  }

 private:
  void solve(const S* last_step, const S* global_step, S* guest_step) {
    PackedTriangle<S> L = link();
    for (int i = kStateColumns - 1; i >= 0; --i) {
      const S* r = L.row(i);
      S sum = less_products(r[width() - 1], r + 2 * kStateColumns, global_step, 0, n_global_);
      sum = less_products(sum, r + kStateColumns, last_step, 0, kStateColumns);
      guest_step[i] = over_pivot(less_products(sum, r, guest_step, i + 1, kStateColumns), r[i]);
    }
  }

  int width() const { return 2 * kStateColumns + n_global_ + 1; }
  /// Rows of guest and last only.
  PackedTriangle<S> link() { return PackedTriangle<S>(link_, width()); }
  void clear_from(int first) {
    PackedTriangle<S> L = link();
    for (int i = first; i < kLinkRows; ++i) {
      S* r = L.row(i);
      for (int c = i; c < width(); ++c) r[c] = S(0);
    }
  }

  void take_from_left() {
    PackedTriangle<S> L = link();
    for (int i = 0; i < kStateColumns; ++i) {
      const S* from = L.row(kStateColumns + i);
      S* to = L.row(i);
      for (int c = i; c < kStateColumns; ++c) to[c] = from[kStateColumns + c];
      for (int c = kStateColumns; c < 2 * kStateColumns; ++c) to[c] = S(0);
      for (int c = 2 * kStateColumns; c < width(); ++c) to[c] = from[c];
    }
    clear_from(kStateColumns);
  }

  /// Folds row i of the 15 of the segment's R that begin at column `from`; they stand at column `to` of the link
  /// triangle. `global`: takes what is left of it; null: it has that already.
  void fold_segment_row(SegmentEliminator<S>* segment, int i, int from, int to, PackedTriangle<S>* global) {
    PackedTriangle<S> L = link();
    const S* r = segment->reduced().R().row(from + i);
    const int guest = segment->layout().guest(), theta = segment->layout().theta();
    for (int c = 0; c < width(); ++c) block_[c] = S(0);
    for (int c = i; c < kStateColumns; ++c) block_[to + c] = r[from + c];
    if (from != guest) {
      for (int c = guest; c < theta; ++c) block_[c - guest] = r[c];
    }
    segment->reduced().to_global_order(r, 0, block_ + 2 * kStateColumns);
    fold_rows(L, block_, 1, width(), 0, kLinkRows);
    const int n = n_global_ + 1;
    if (global) fold_rows(*global, block_ + kLinkRows, 1, n, 0, n);
  }

  /// The columns of "last" are zero there.
  void keep(LeftRows<S>* left) { copy_rows(0, left); }
  void restore(const LeftRows<S>& left) { take_rows(0, left); }

  /// 15 rows from column `first` on: those of the guest (0) or of the last keyframe.
  void copy_rows(int first, LeftRows<S>* rows) {
    PackedTriangle<S> L = link();
    S* out = rows->data;
    for (int i = 0; i < kStateColumns; ++i) {
      const S* r = L.row(first + i);
      for (int c = i; c < kStateColumns; ++c) *out++ = r[first + c];
      for (int c = 2 * kStateColumns; c < width(); ++c) *out++ = r[c];
    }
  }
  void take_rows(int first, const LeftRows<S>& rows) {
    PackedTriangle<S> L = link();
    clear_from(0);
    const S* from = rows.data;
    for (int i = 0; i < kStateColumns; ++i) {
      S* r = L.row(first + i);
      for (int c = i; c < kStateColumns; ++c) r[first + c] = *from++;
      for (int c = 2 * kStateColumns; c < width(); ++c) r[c] = *from++;
    }
  }

  /// Row i of what touches ties and theta only.
  void fold_global(SegmentEliminator<S>* segment, int i, PackedTriangle<S>* global) {
    const int n = n_global_ + 1;
    segment->reduced().global_row(i, block_);
    fold_rows(*global, block_, 1, n, 0, n);
  }

  static constexpr int kRowsPerSlice = 5;
  static constexpr int kLinkRows = 2 * kStateColumns;
  int n_global_ = 0;
  Place place_ = 0;
  std::int32_t row_ = 0;
  S link_[packed_size(kLinkColumns) - packed_size(kLinkColumns - kLinkRows)];
  S block_[kLinkColumns];
};

}  // namespace SEGCAL_NS
