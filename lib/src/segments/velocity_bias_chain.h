// Velocities and biases of a segment's keyframes, eliminated in time order (docs/design.md, section 5, step 2).
//
// An IMU link ties keyframe k to k + 1. Its 15 rows meet the nine rows that earlier links left on keyframe k's velocity
// and biases; nine reflections finish keyframe k, nine more leave the rows of keyframe k + 1, and the six that remain
// touch poses, guest and theta only and go to the reduced system. Columns of a row:
// [vb k 9 | vb k + 1 9 | rhs | guest 15 | IMU part of theta 15 and
// terms | poses 6 K]; poses last, so that only those seen so far cost.
//
// Back-substitution runs the chain a second time with everything but velocities and biases known: rows are then 19
// wide, which costs an integration of the samples and saves the memory that the full rows would take. The finished ones
// stand where the triangle was: all else is known.
#pragma once

#include "math/one_of.h"
#include "math/resumable.h"
#include "segments/reduced_system.h"

namespace SEGCAL_NS {

template <class S>
class VelocityBiasChain {
 public:
  static constexpr int kNext = kVelocityBiasColumns;
  static constexpr int kRhs = 2 * kVelocityBiasColumns;
  static constexpr int kSolved = kRhs + 1;  ///< width when all else is known
  static constexpr int kGuest = kSolved;
  static constexpr int kImu = kGuest + kStateColumns;
  static constexpr int kKept = kMaxKeyframes * kVelocityBiasColumns * kSolved;
  static constexpr int kWidth = kImu + kImuColumns + kMaxEffectColumns + kPoseColumns * kMaxKeyframes;

  /// `known`: null to eliminate; else a step in the reduced layout, for
  /// back-substitution, which needs kKept numbers of memory to keep.
  void begin(const S* known, const ReducedLayout& layout, S* memory) {
    known_ = known;
    kept_ = memory;
    poses_ = kImu + layout.imu_columns();
    current_ = 0;
    links_ = 0;
    handed_ = hand_until_ = 0;
    place_ = 0;
    for (S& v : now_) v = S(0);
  }
  /// The next link's rows, until they are added: what is handed over stands there only later.
  ImuRows<S>& begin_rows() { return spread_.template begin<ImuRows<S>>(); }
  /// Links folded so far.
  int links() const { return links_; }

  /// A row on one velocity or bias column (0..8) of the current keyframe.
  [[gnu::cold]] void add_scalar(int column, S weight, S rhs, ReducedSystem<S>* rest) {
    clear(1);
    block_[column] = weight;
    block_[kRhs] = rhs;
    fold_into_current(1, rest->layout());
    while (!hand_over_step(rest)) {
    }
  }

  /// Bias walk from the guest to the current keyframe, six rows. As the links below: what is left of the rows goes to
  /// the reduced system with hand_over_step().
  void add_bias_link(const Vec3<S>& d_ba, const Vec3<S>& d_bg, S weight_a, S weight_g, ReducedSystem<S>* rest) {
    clear(6);
    for (int i = 0; i < 6; ++i) {
      const S w = i < 3 ? weight_a : weight_g;
      S* r = block_ + i * kWidth;
      r[3 + i] = w;
      r[kGuest + 9 + i] = -w;
      r[kRhs] = -w * (i < 3 ? d_ba(i) : d_bg(i - 3));
    }
    fold_into_current(6, rest->layout());
  }

  /// Link from the guest (the segment before) to the first keyframe.
  void add_guest_link(const ImuRows<S>& rows, const ImuTermColumns<S>& terms, ReducedSystem<S>* rest) {
    clear(15);
    for (int i = 0; i < 15; ++i) {
      S* r = block_ + i * kWidth;
      for (int c = 0; c < kStateColumns; ++c) r[kGuest + c] = rows.J(i, c);
      put_state(rows, i, kStateColumns, 0, 0);
      put_theta(rows, terms, i);
    }
    ++links_;
    fold_into_current(15, rest->layout());
  }

  /// Link from the current keyframe to the next one, which becomes the current one; finish_current() and move_on() go
  /// on with it, each a slice's work.
  void begin_link(const ImuRows<S>& rows, const ImuTermColumns<S>& terms, ReducedSystem<S>* rest) {
    clear(15);
    for (int i = 0; i < 15; ++i) {
      put_state(rows, i, 0, 0, current_);
      put_state(rows, i, kStateColumns, kNext, current_ + 1);
      put_theta(rows, terms, i);
    }
    ++links_;
    ++current_;
    substitute(15, rest->layout());
  }
  void finish_current() {
    eliminate_current(15, active_width());
    if (known_) store(current_ - 1);
  }
  void move_on() {
    const int n = active_width();
    // The next keyframe's nine columns, within the block; its first nine rows become the rows of the current keyframe.
    reflect_leading_columns(block_ + kNext, 15, kWidth, n - kNext, kVelocityBiasColumns);
    take_next(n);
    handed_ = kVelocityBiasColumns;
    hand_until_ = 15;
  }

  /// Gives the rows that have no velocity or bias left to the reduced system; true when it has them all.
  bool hand_over_step(ReducedSystem<S>* rest) {
    if (known_) return true;
    SEGCAL_SLICES(place_) {
      for (; handed_ < hand_until_; handed_ += kPoseColumns) {
        spread_rows(rest);
        SEGCAL_AWAIT(place_, rest->fold_step());
      }
    }
    SEGCAL_SLICES_END(place_);
  }

  /// The last keyframe stays in the reduced system: its rows go there, with fold_step().
  void finish(ReducedSystem<S>* rest) {
    const ReducedLayout& at = rest->layout();
    for (int i = 0; i < kVelocityBiasColumns; ++i) {
      const S* r = now_ + i * kWidth;
      S* out = block_ + i * kReducedColumns;
      spread(r, at, out);
      for (int c = 0; c < kVelocityBiasColumns; ++c) out[at.last() + kPoseColumns + c] = c < i ? S(0) : r[c];
    }
    rest->begin_fold(block_, kVelocityBiasColumns, kReducedColumns, 0);
  }

  /// Steps of velocity and biases of keyframes current() - 1 down to 0, after a run with known poses.
  /// `out`: nine entries per keyframe, `stride` apart; those of the last keyframe are filled in already.
  void back_substitute(S* out, int stride) const {
    for (int k = current_ - 1; k >= 0; --k) {
      S* v = out + k * stride;
      const S* next = out + (k + 1) * stride;
      for (int i = kVelocityBiasColumns - 1; i >= 0; --i) {
        const S* r = kept_ + (k * kVelocityBiasColumns + i) * kSolved;
        const S sum = less_products(r[kRhs], r, v, i + 1, kVelocityBiasColumns);
        v[i] = over_pivot(less_products(sum, r + kNext, next, 0, kVelocityBiasColumns), r[i]);
      }
    }
  }

 private:
  /// Columns in use: poses up to the current keyframe, unless they are known.
  int active_width() const { return known_ ? kSolved : poses_ + kPoseColumns * (current_ + 1); }
  /// Takes what is known to the right-hand side.
  void substitute(int m, const ReducedLayout& at) {
    if (!known_) return;
    for (int i = 0; i < m; ++i) {
      S* r = block_ + i * kWidth;
      S sum = S(0);
      for (int c = 0; c < at.guest_columns; ++c) sum += r[kGuest + c] * known_[at.guest() + c];
      for (int c = 0; c < at.imu_columns(); ++c) sum += r[kImu + c] * known_[at.imu() + c];
      for (int c = 0; c < kPoseColumns * at.keyframes; ++c) sum += r[poses_ + c] * known_[c];
      r[kRhs] -= sum;
    }
  }
  void clear(int rows) {
    for (int c = 0; c < rows * kWidth; ++c) block_[c] = S(0);
  }
  void put_state(const ImuRows<S>& rows, int i, int from, int to, int keyframe) {
    S* r = block_ + i * kWidth;
    for (int c = 0; c < kPoseColumns; ++c) r[poses_ + kPoseColumns * keyframe + c] = rows.J(i, from + c);
    for (int c = 0; c < kVelocityBiasColumns; ++c) r[to + c] = rows.J(i, from + kPoseColumns + c);
  }
  void put_theta(const ImuRows<S>& rows, const ImuTermColumns<S>& terms, int i) {
    S* r = block_ + i * kWidth;
    for (int c = 0; c < kImuColumns; ++c) r[kImu + c] = rows.J(i, 2 * kStateColumns + c);
    for (int t = 0; t < terms.count(); ++t) r[kImu + kImuColumns + t] = terms.link[t][i];
    r[kRhs] = -rows.r(i);
  }
  /// Nine reflections against the rows of the current keyframe's velocity and biases.
  void eliminate_current(int m, int n) {
    for (int j = 0; j < kVelocityBiasColumns; ++j) reflect_column(now_ + j * kWidth, block_, m, kWidth, j, n);
  }
  void fold_into_current(int m, const ReducedLayout& at) {
    substitute(m, at);
    eliminate_current(m, active_width());
    handed_ = 0;
    hand_until_ = m;
  }
  /// Keeps the finished rows of keyframe k.
  void store(int k) {
    for (int i = 0; i < kVelocityBiasColumns; ++i) {
      for (int c = 0; c < kSolved; ++c) kept_[(k * kVelocityBiasColumns + i) * kSolved + c] = now_[i * kWidth + c];
    }
  }
  void take_next(int n) {
    for (int i = 0; i < kVelocityBiasColumns; ++i) {
      S* to = now_ + i * kWidth;
      const S* from = block_ + i * kWidth;
      for (int c = 0; c < kVelocityBiasColumns; ++c) to[c] = c < i ? S(0) : from[kNext + c];
      for (int c = kNext; c < kRhs; ++c) to[c] = S(0);
      for (int c = kRhs; c < n; ++c) to[c] = from[c];
      for (int c = n; c < kWidth; ++c) to[c] = S(0);
    }
  }
  /// A row's guest, theta, rhs and poses in the reduced layout.
  void spread(const S* r, const ReducedLayout& at, S* out) const {
    for (int c = 0; c < at.width(); ++c) out[c] = S(0);
    for (int c = 0; c < kPoseColumns * at.keyframes; ++c) out[c] = r[poses_ + c];
    for (int c = 0; c < at.guest_columns; ++c) out[at.guest() + c] = r[kGuest + c];
    for (int c = 0; c < at.imu_columns(); ++c) out[at.imu() + c] = r[kImu + c];
    out[at.rhs()] = r[kRhs];
  }
  /// Puts the block's next rows into the reduced system's layout, to be folded there.
  void spread_rows(ReducedSystem<S>* rest) {
    const int rows = hand_until_ - handed_ < kPoseColumns ? hand_until_ - handed_ : kPoseColumns;
    S* out = spread_.template begin<SpreadRows>().number;
    for (int r = 0; r < rows; ++r) {
      spread(block_ + (handed_ + r) * kWidth, rest->layout(), out + r * kReducedColumns);
    }
    rest->begin_fold(out, rows, kReducedColumns, 0);
  }

  static constexpr int kBlockRows = 15;
  static constexpr int kBlockSize =
      kBlockRows * kWidth > 9 * kReducedColumns ? kBlockRows* kWidth : 9 * kReducedColumns;
  static_assert(kKept <= ReducedSystem<S>::kNumbers, "the triangle's memory is too small to keep the chain's rows");
  NearOrNull<const S> known_;
  Near<S> kept_;
  int current_ = 0, links_ = 0, poses_ = 0, handed_ = 0, hand_until_ = 0;
  Place place_ = 0;
  S now_[kVelocityBiasColumns * kWidth];
  S block_[kBlockSize];
  struct SpreadRows {
    S number[kPoseColumns * kReducedColumns];
  };
  OneOf<ImuRows<S>, SpreadRows> spread_;
};

}  // namespace SEGCAL_NS
