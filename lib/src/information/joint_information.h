// What several segments say together: sums of information as triangles, R'R = 1 + sum of W'W with W = R_theta
// diag(sigma of the prior), so that the prior is the identity whatever the units.
//
// Sums are folds, never differences: taking a segment out of a sum cancels where that segment alone knew a direction.
// Leave-one-out sums come from halving instead: the sum without segment i is the sum without the half that i is in, and
// so on down. Each segment is folded once per halving.
#pragma once

#include "information/segment_information.h"
#include "math/near.h"
#include "math/resumable.h"

namespace SEGCAL_NS {

/// Halvings until a list of n has come down to one.
constexpr int halvings(int n) {
  int levels = 0;
  while ((1 << levels) < n) ++levels;
  return levels;
}

/// Segments that are compared at a time: those kept and a new one.
constexpr int kMaxCompared = SEGCAL_MAX_SEGMENTS + 1;
constexpr int kSumLevels = halvings(kMaxCompared) + 1;
/// Numbers of memory that JointInformation needs.
constexpr int kJointScratch = kSumLevels * packed_size(kMaxTheta) + kMaxTheta * (kMaxTheta + 1);

/// Folds the leading `rows` rows of an upper-triangular block (n rows, `stride` apart, all columns of T) into T.
template <class S>
void fold_triangle(S* block, int rows, int stride, PackedTriangle<S>* T) {
  for (int j = 0; j < T->columns(); ++j) {
    const int reached = j + 1 < rows ? j + 1 : rows;  // rows below begin further right
    reflect_column(T->row(j), block, reached, stride, j, T->columns());
  }
}

template <class S>
class JointInformation {
 public:
  JointInformation() = default;  ///< to be assigned to before use
  /// `scratch`: kJointScratch numbers, lent. `prior_sigma`: of theta's n entries.
  JointInformation(const S* prior_sigma, int n, S* scratch) : prior_sigma_(prior_sigma), n_(n), scratch_(scratch) {}

  /// The triangle of the prior and `count` segments over theta's columns in units of the prior's sigmas.
  PackedTriangle<S> sum(const SegmentInformation<S>* const* segment, int count) {
    const PackedTriangle<S> T = prior(0);
    for (int i = 0; i < count; ++i) add(*segment[i], 0);
    return T;
  }

  /// Nats that the prior gains from all segments but the i-th, for each i: half of log det. count <= kMaxCompared. In
  /// slices; true when gain_without(i) tells.
  [[gnu::cold]] bool gains_without_one_step(const SegmentInformation<S>* const* segment, int count) {
    SEGCAL_SLICES(place_) {
      for (int level = 0; level < kSumLevels; ++level) first_[level] = last_[level] = 0;
      prior(0);
      last_[0] = count;
      for (i_ = 0; i_ < count; ++i_) {
        for (level_ = 0; last_[level_] - first_[level_] > 1;) {
          if (!descend()) continue;
          for (; k_ < until_; ++k_) {
            add(*segment[k_], level_);
            if (k_ % kAddsPerSlice == kAddsPerSlice - 1) SEGCAL_PAUSE(place_);
          }
        }
        gain_[i_] = gain_of(triangle(level_));
        SEGCAL_PAUSE(place_);
      }
    }
    SEGCAL_SLICES_END(place_);
  }
  S gain_without(int i) const { return gain_[i]; }
  void gains_without_one(const SegmentInformation<S>* const* segment, int count, S* gain) {
    while (!gains_without_one_step(segment, count)) {
    }
    for (int i = 0; i < count; ++i) gain[i] = gain_[i];
  }

  /// Nats that the prior gained in T: the sum of log |T_jj|.
  static S gain_of(const PackedTriangle<S>& T) {
    S sum = S(0);
    for (int j = 0; j < T.columns(); ++j) sum += logarithm(absolute(T(j, j)));
    return sum;
  }

 private:
  PackedTriangle<S> triangle(int level) { return PackedTriangle<S>(scratch_ + level * packed_size(n_), n_); }
  S* block() { return scratch_ + kSumLevels * packed_size(n_); }

  PackedTriangle<S> prior(int level) {
    PackedTriangle<S> T = triangle(level);
    T.clear();
    for (int j = 0; j < n_; ++j) T.row(j)[j] = S(1);
    return T;
  }

  /// To the half that segment i_ is in: the next level is a copy of the one above,
  /// to which the other half, [k_, until_), is to be added. False if all that is
  /// there already: halves come in order, and the segment before had the same one.
  bool descend() {
    const int a = first_[level_], b = last_[level_], middle = a + (b - a) / 2;
    const bool left = i_ < middle;
    const int from = left ? a : middle, to = left ? middle : b;
    ++level_;
    if (first_[level_] == from && last_[level_] == to) return false;
    first_[level_] = from;
    last_[level_] = to;
    k_ = left ? middle : a;
    until_ = left ? b : middle;
    const S* above = scratch_ + (level_ - 1) * packed_size(n_);
    S* here = scratch_ + level_ * packed_size(n_);
    for (int k = 0; k < packed_size(n_); ++k) here[k] = above[k];
    return true;
  }

  [[gnu::cold]] void add(const SegmentInformation<S>& information, int level) {
    PackedTriangle<S> T = triangle(level);
    S* B = block();
    for (int i = 0; i < n_; ++i) {
      for (int j = 0; j < n_; ++j) B[i * n_ + j] = j < i ? S(0) : information.R(i, j) * prior_sigma_[j];
    }
    fold_triangle(B, n_, n_, &T);
  }

  static constexpr int kAddsPerSlice = 4;
  Near<const S> prior_sigma_;
  int n_ = 0;
  Near<S> scratch_;
  Place place_ = 0;
  std::int32_t i_ = 0, level_ = 0, k_ = 0, until_ = 0;
  std::int32_t first_[kSumLevels] = {}, last_[kSumLevels] = {};  // the part that each level leaves out
  S gain_[kMaxCompared] = {};
};

}  // namespace SEGCAL_NS
