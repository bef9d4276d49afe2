// What several segments say together: sums of information as triangles, R'R = 1 + sum of W'W with W = R_theta diag(sigma
// of the prior), so that the prior is the identity whatever the units.
//
// Sums are folds, never differences: taking a segment out of a sum cancels where that segment alone knew a direction.
// Leave-one-out sums come from halving instead: the sum without segment i is the sum without the half that i is in, and
// so on down. Each segment is folded once per halving.
#pragma once

#include "information/segment_information.h"

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
  /// `scratch`: kJointScratch numbers, lent. `prior_sigma`: of theta's n entries.
  JointInformation(const S* prior_sigma, int n, S* scratch) : prior_sigma_(prior_sigma), n_(n), scratch_(scratch) {}

  /// The triangle of the prior and `count` segments over theta's columns in units of the prior's sigmas.
  PackedTriangle<S> sum(const SegmentInformation<S>* const* segment, int count) {
    PackedTriangle<S> T = prior(0);
    for (int i = 0; i < count; ++i) add(*segment[i], &T);
    return T;
  }

  /// Nats that the prior gains from all segments but the i-th, for each i: half of log det. count <= kMaxCompared.
  void gains_without_one(const SegmentInformation<S>* const* segment, int count, S* gain) {
    int first[kSumLevels] = {}, last[kSumLevels] = {};  // the part that each level leaves out
    prior(0);
    last[0] = count;
    for (int i = 0; i < count; ++i) {
      int level = 0;
      while (last[level] - first[level] > 1) {
        const int a = first[level], b = last[level], middle = a + (b - a) / 2;
        const bool left = i < middle;
        ++level;
        const int from = left ? a : middle, to = left ? middle : b;
        // Parts come in order: one that was left out on the way to the segment before is still there.
        if (first[level] == from && last[level] == to) continue;
        first[level] = from;
        last[level] = to;
        descend(segment, level, left ? middle : a, left ? b : middle);
      }
      gain[i] = gain_of(triangle(level));
    }
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

  /// Level `level` is the level above and the segments [from, to).
  void descend(const SegmentInformation<S>* const* segment, int level, int from, int to) {
    const S* above = scratch_ + (level - 1) * packed_size(n_);
    S* here = scratch_ + level * packed_size(n_);
    for (int k = 0; k < packed_size(n_); ++k) here[k] = above[k];
    PackedTriangle<S> T = triangle(level);
    for (int i = from; i < to; ++i) add(*segment[i], &T);
  }

  void add(const SegmentInformation<S>& information, PackedTriangle<S>* T) {
    S* B = block();
    for (int i = 0; i < n_; ++i) {
      for (int j = 0; j < n_; ++j) B[i * n_ + j] = j < i ? S(0) : information.R(i, j) * prior_sigma_[j];
    }
    fold_triangle(B, n_, n_, T);
  }

  const S* prior_sigma_;
  int n_;
  S* scratch_;
};

}  // namespace SEGCAL_NS
