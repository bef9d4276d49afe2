// How far do segments disagree about theta? The variance of what
// is left of each one's pull, over what noise as stated leaves.
//
// With theta at its best, segment s still pulls with g = R'd (R, d: its information at that theta, alone).
// Independent noise of unit variance gives g the covariance H - H Sigma H, with H = R'R and Sigma =
// (T'T)^-1 the covariance of theta from all. Errors that last for a whole segment (corner tracks that
// drift, vibration, a calibration that moves, an effect without a name) make pulls longer, and theta's
// covariance is Sigma (sum of g g') Sigma in place of Sigma (White, "Maximum likelihood estimation of
// misspecified models", Econometrica 1982; Liang and Zeger, Biometrika 1986, with each segment a cluster).
// Eight clusters do not fill a matrix of 27 columns: only the mean over all directions is taken,
//     sum of g'Sigma g / sum of trace(H Sigma - H Sigma H Sigma),
// a factor on Sigma that chi2/dof does not see: residuals that are small, but not independent.
#pragma once

#include "information/segment_information.h"
#include "math/near.h"
#include "math/resumable.h"

namespace SEGCAL_NS {

template <class S>
class SegmentScatter {
 public:
  static constexpr int kScratch = kMaxTheta * (kMaxTheta + 1);

  SegmentScatter() = default;
  /// `T`: triangle over [theta | rhs] from all segments and the prior,
  /// at its optimum. `scratch`: kScratch numbers. Both must stay.
  SegmentScatter(PackedTriangle<S> T, int n, S* scratch)
      : triangle_(T.row(0)), width_(T.columns()), n_(n), scratch_(scratch) {}

  /// Takes a segment's information, in slices, linearised at that theta, or with theta `offset` from there (n numbers).
  bool take_step(const SegmentInformation<S>& information, const S* offset = nullptr) {
    SEGCAL_SLICES(place_) {
      for (int i = 0; i < n_; ++i) pull()[i] = S(0);
      for (i_ = 0; i_ < n_; ++i_) {
        add_row(information, offset);
        SEGCAL_PAUSE(place_);
      }
      for (int i = 0; i < n_; ++i) found_ += pull()[i] * pull()[i];
      for (i_ = 0; i_ < n_; ++i_) {
        take_off_row();
        SEGCAL_PAUSE(place_);
      }
    }
    SEGCAL_SLICES_END(place_);
  }
  /// What other segments are known to disagree by: a sum of squares, and what noise of unit variance leaves of it.
  void add(S found, S expected) {
    found_ += found;
    expected_ += expected;
  }
  S found() const { return found_; }
  S expected() const { return expected_; }
  /// Of the pulls that were taken, in units of stated noise; 0 if they tell nothing.
  S variance() const { return expected_ > S(0) ? found_ / expected_ : S(0); }

 private:
  S* row(int i) { return scratch_ + n_ * i; }
  S* pull() { return scratch_ + n_ * n_; }

  /// Row i of Y = R T^-1, upper triangular; |Y|^2 = trace(H Sigma) and |Y'd|^2 = g'Sigma g.
  void add_row(const SegmentInformation<S>& information, const S* offset) {
    const PackedTriangle<S> T(triangle_, width_);
    S* y = row(i_);
    S left = information.d(i_);
    for (int c = i_; offset && c < n_; ++c) left -= information.R(i_, c) * offset[c];
    for (int c = 0; c < n_; ++c) {
      S sum = c < i_ ? S(0) : information.R(i_, c);
      for (int k = i_; k < c; ++k) sum -= y[k] * T(k, c);
      y[c] = c < i_ || T(c, c) == S(0) ? S(0) : sum / T(c, c);
      expected_ += y[c] * y[c];
      pull()[c] += y[c] * left;
    }
  }
  /// Row i of Y'Y: |Y'Y|^2 = trace(H Sigma H Sigma).
  void take_off_row() {
    for (int j = 0; j < n_; ++j) {
      S sum = S(0);
      for (int k = 0; k <= (i_ < j ? i_ : j); ++k) sum += row(k)[i_] * row(k)[j];
      expected_ -= sum * sum;
    }
  }

  Near<S> triangle_;
  std::int32_t width_ = 1, n_ = 0;
  std::int32_t i_ = 0;
  Near<S> scratch_;
  S found_ = S(0), expected_ = S(0);
  Place place_ = 0;
};

}  // namespace SEGCAL_NS
