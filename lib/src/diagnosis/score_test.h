// Score tests: would an effect that the model lacks explain the residuals? (docs/diagnosis.md, section 7)
//
// The elimination hands out a triangle over [theta | terms | rhs], linearised where
// all terms are zero, the prior of theta folded in. Its rows below theta's are what
// the data say about the terms with theta free: min over theta of the cost is
//     |R_cc c - d_c|^2 + rho^2.
// An effect e owns a few of the columns c. With all other candidates held at zero,
// and those that were accepted before free like theta, the columns [accepted | e |
// rhs] of R_cc are brought to a triangle once more; in its rows of e stand R_ee, d_e:
//     statistic   s = |d_e|^2: what the cost falls by if e is let free; without e, chi-square with dim(e) degrees,
//     estimate    R_ee^-1 d_e,  covariance  (R_ee' R_ee)^-1.
// No refit, and only columns that are there already: a few thousand multiplications per effect.
#pragma once

#include "math/qr.h"
#include "math/small_solvers.h"

namespace SEGCAL_NS {

/// Columns of one effect, counted from the first column behind theta's.
struct TermGroup {
  std::int32_t first = 0, count = 0;
};

/// An effect has at most this many parameters (gyro_g_sensitivity).
constexpr int kMaxGroupColumns = 9;

/// A column of which less than this share is left when theta and the accepted effects are taken out of it is one of
/// them in disguise: its direction is rounding, and says nothing.
template <class S>
constexpr S kCollinear = std::is_same_v<S, float> ? S(3e-5) : S(1e-9);

template <class S>
struct EffectScore {
  std::int32_t dof = 0;  ///< columns that are no combination of theta and the accepted effects
  S statistic = S(0);
  S estimate[kMaxGroupColumns] = {};  ///< in the columns' units; 0 for a column without a direction of its own
  S covariance[kMaxGroupColumns * kMaxGroupColumns] = {};  ///< row-major, count x count; 0 for such a column

  S sigma(int i, int count) const { return square_root(covariance[i * count + i]); }
};

template <class S>
class ScoreTest {
 public:
  /// Numbers of memory for `terms` columns behind theta's.
  static constexpr int scratch_size(int terms) { return terms * (terms + 1) + packed_size(terms + 1); }

  /// `R`: over [theta | terms | rhs], not changed. `scratch`: scratch_size(R.columns() - 1 - n_theta) numbers, lent.
  ScoreTest(const PackedTriangle<S>& R, int n_theta, S* scratch, S collinear = kCollinear<S>)
      : R_(R), n_theta_(n_theta), terms_(R.columns() - 1 - n_theta), scratch_(scratch), collinear_(collinear) {}

  /// Of one effect, with the `n` accepted ones free. Groups do not overlap.
  [[gnu::cold]] EffectScore<S> of(const TermGroup& effect, const TermGroup* accepted = nullptr, int n = 0) {
    width_ = 0;
    for (int i = 0; i < n; ++i) gather(accepted[i]);
    const int before = width_;
    gather(effect);
    copy_column(R_.columns() - 1, width_);
    PackedTriangle<S> T(scratch_ + terms_ * (terms_ + 1), width_ + 1);
    T.clear();
    int done = 0;
    for (int i = 0; i < n; ++i) done = clear_columns(accepted[i], done, &T);
    clear_columns(effect, done, &T);
    return read(T, effect, before);
  }

 private:
  void gather(const TermGroup& group) {
    for (int c = 0; c < group.count; ++c) copy_column(n_theta_ + group.first + c, width_++);
  }

  /// Column c of the rows below theta's into column `to` of the block.
  void copy_column(int c, int to) {
    for (int i = 0; i < terms_; ++i) scratch_[i * (terms_ + 1) + to] = n_theta_ + i <= c ? R_(n_theta_ + i, c) : S(0);
  }

  /// Brings the block's columns of a group, from column `j` on, to rows of T. A column that is a combination of those
  /// before keeps a row of zeroes: its reflection would take an arbitrary direction away from the columns after it.
  [[gnu::cold]] int clear_columns(const TermGroup& group, int j, PackedTriangle<S>* T) {
    for (int i = 0; i < group.count; ++i, ++j) {
      const S limit = collinear_ * length(n_theta_ + group.first + i);
      if (square_sum(scratch_ + j, terms_, terms_ + 1) <= limit * limit) continue;
      fold_rows(*T, scratch_, terms_, terms_ + 1, j, j + 1);
    }
    return j;
  }

  /// Length of a column before theta was taken out of it.
  S length(int c) const {
    S sum = S(0);
    for (int i = 0; i <= c; ++i) sum += R_(i, c) * R_(i, c);
    return square_root(sum);
  }

  EffectScore<S> read(const PackedTriangle<S>& T, const TermGroup& effect, int before) const {
    EffectScore<S> out;
    const int m = effect.count, rhs = T.columns() - 1;
    bool own[kMaxGroupColumns];
    for (int i = 0; i < m; ++i) {
      own[i] = T(before + i, before + i) != S(0);
      out.dof += own[i] ? 1 : 0;
      out.statistic += T(before + i, rhs) * T(before + i, rhs);
    }
    solve(T, before, m, own, out.estimate);
    covariance(T, before, m, own, out.covariance);
    return out;
  }

  static void solve(const PackedTriangle<S>& T, int before, int m, const bool* own, S* x) {
    for (int i = m - 1; i >= 0; --i) {
      const S sum = less_products(T(before + i, T.columns() - 1), T.row(before + i) + before, x, i + 1, m);
      x[i] = own[i] ? sum / T(before + i, before + i) : S(0);
    }
  }

  /// Sum of the outer products of the columns of R_ee^-1.
  static void covariance(const PackedTriangle<S>& T, int before, int m, const bool* own, S* out) {
    S x[kMaxGroupColumns];
    for (int k = 0; k < m; ++k) {
      if (!own[k]) continue;
      for (int i = k; i >= 0; --i) {
        const S sum = less_products(i == k ? S(1) : S(0), T.row(before + i) + before, x, i + 1, k + 1);
        x[i] = own[i] ? sum / T(before + i, before + i) : S(0);
      }
      for (int i = 0; i <= k; ++i) {
        for (int j = 0; j <= k; ++j) out[i * m + j] += x[i] * x[j];
      }
    }
  }

  const PackedTriangle<S>& R_;
  int n_theta_, terms_, width_ = 0;
  S* scratch_;
  S collinear_;
};

}  // namespace SEGCAL_NS
