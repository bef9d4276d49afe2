// Do segments tell of one and the same theta? A device that was dropped, or whose lens was turned, has another calibration
// than its older segments know.
//
// Segments are taken from the newest to the oldest. Each is held against the prior and all newer ones that agreed: with R_1
// delta = d_1 from the one and R_2 delta = d_2 from the others, what their common least-squares solution leaves over is
//     (delta_1 - delta_2)' (Sigma_1 + Sigma_2)^-1 (delta_1 - delta_2),
// chi-square with the rank of R_1 as degrees of freedom if theta is the same and the model is all there is. It needs no
// inverse, so directions that a segment does not show do no harm; they are left out of R_1, where they would only add noise.
//
// No model is all there is: on real recordings neighbours of a few seconds disagree by two to six per degree of freedom. So
// the measure is what the newer ones disagree among themselves, at least 1, and the ratio of the two mean squares is F.
// One segment alone convicts nobody, then, and nor do several that could not stand in for what they convict.
#pragma once

#include "calibration/prior.h"
#include "information/marginal.h"
#include "information/metrics.h"
#include "math/quantiles.h"

namespace SEGCAL_NS {

template <class S>
class Agreement {
 public:
  static constexpr int kScratch = 2 * packed_size(kMaxTheta + 1) + kMaxTheta * (kMaxTheta + 1);

  Agreement() = default;
  /// All segments' information must be linearised at `theta`. `level`: probability of a false verdict in one comparison.
  /// `noise`: variance of whitened residuals, 1 where the noise is as stated. Memory is lent; all arguments must stay.
  Agreement(const ThetaPrior<S>& prior, const Calibration<S>& theta, S level, S noise, InformationAnalysis<S>* analysis, S* scratch)
      : prior_(&prior), theta_(&theta), n_(theta.columns()), level_(level), noise_(noise), analysis_(analysis), scratch_(scratch) {
    begin();
  }

  /// Takes the next older segment, in slices; true when outdated() is its verdict. An outdated one says nothing to the rest.
  bool take_step(const SegmentInformation<S>& information) {
    SEGCAL_SLICES(place_) {
      outdated_ = false;
      if (agreed_ > 0) {
        begin_analysis(information, prior_->sigma, analysis_);
        SEGCAL_AWAIT(place_, analyse_step(information.n_theta, analysis_));
        compare(information);
        outdated_ = contradicted() && know_enough();
        SEGCAL_PAUSE(place_);
      }
      if (!outdated_) agree(information);
    }
    SEGCAL_SLICES_END(place_);
  }
  bool outdated() const { return outdated_; }
  /// What is known of the spread already: a sum of squares of unit variance, with `degrees` of freedom.
  void know_spread(S sum, int degrees) {
    spread_ += sum / noise_;
    spread_degrees_ += degrees;
  }
  bool outdated(const SegmentInformation<S>& information) {
    while (!take_step(information)) {
    }
    return outdated_;
  }

 private:
  void agree(const SegmentInformation<S>& information) {
    if (agreed_ > 0) {
      spread_ += statistic_;
      spread_degrees_ += degrees_;
    }
    PackedTriangle<S> T = newer();
    add(information, &T);
    ++agreed_;
  }
  PackedTriangle<S> newer() { return PackedTriangle<S>(scratch_, n_ + 1); }
  PackedTriangle<S> trial() { return PackedTriangle<S>(scratch_ + packed_size(n_ + 1), n_ + 1); }
  S* block() { return scratch_ + 2 * packed_size(n_ + 1); }

  /// The prior alone, in units of its sigmas.
  void begin() {
    PackedTriangle<S> T = newer();
    S offset[kMaxTheta];
    difference(prior_->mean, *theta_, offset);
    T.clear();
    for (int i = 0; i < n_; ++i) {
      T.row(i)[i] = S(1);
      T.row(i)[n_] = -offset[i] / prior_->sigma[i];
    }
  }

  bool know_enough() {
    S work[kMaxTheta];
    return knows_half(newer(), n_, work);
  }

  S entry(const SegmentInformation<S>& information, int i, int c) const {
    if (c < i) return S(0);
    return c < n_ ? information.R(i, c) * prior_->sigma[c] : information.d(i);
  }

  void add(const SegmentInformation<S>& information, PackedTriangle<S>* T) {
    S* B = block();
    for (int i = 0; i < n_; ++i) {
      for (int c = 0; c <= n_; ++c) B[i * (n_ + 1) + c] = entry(information, i, c);
    }
    fold_rows(*T, B, n_, n_ + 1, 0, n_ + 1);
  }

  /// The limit grows with how little is known about the spread.
  bool contradicted() const {
    if (degrees_ == 0 || spread_degrees_ == 0) return false;
    const S limit = f_upper_quantile(degrees_, spread_degrees_, level_), spread = spread_ / S(spread_degrees_);
    return limit > S(0) && statistic_ > limit * S(degrees_) * (spread > S(1) ? spread : S(1));
  }

  void compare(const SegmentInformation<S>& information) {
    degrees_ = 0;
    statistic_ = S(0);
    while (degrees_ < n_ && analysis_->relative_sigma(degrees_) < kExcited<S>) shown_row(information, degrees_++);
    if (degrees_ == 0) return;
    PackedTriangle<S> T = trial();
    for (int k = 0; k < packed_size(n_ + 1); ++k) scratch_[packed_size(n_ + 1) + k] = scratch_[k];
    T.row(n_)[n_] = S(0);
    fold_rows(T, block(), degrees_, n_ + 1, 0, n_ + 1);
    statistic_ = T(n_, n_) * T(n_, n_) / noise_;
  }

  /// Row i of [U'R_1 | U'd_1] = [s_i V_i' | U_i'd_1] into the block, with U_i = R_1 V_i / s_i.
  void shown_row(const SegmentInformation<S>& information, int i) {
    S* row = block() + i * (n_ + 1);
    const S s = analysis_->s[i];
    row[n_] = S(0);
    for (int r = 0; r < n_; ++r) {
      S u = S(0);
      for (int c = r; c < n_; ++c) u += entry(information, r, c) * analysis_->V[c * n_ + i];
      row[n_] += u / s * information.d(r);
    }
    for (int c = 0; c < n_; ++c) row[c] = s * analysis_->V[c * n_ + i];
  }

  const ThetaPrior<S>* prior_ = nullptr;
  const Calibration<S>* theta_ = nullptr;
  int n_ = 0, agreed_ = 0, degrees_ = 0, spread_degrees_ = 0;
  S level_ = S(0), noise_ = S(1), statistic_ = S(0), spread_ = S(0);  // of the last comparison; of all that agreed
  InformationAnalysis<S>* analysis_ = nullptr;
  S* scratch_ = nullptr;
  Place place_ = 0;
  bool outdated_ = false;
};

/// Variance of whitened residuals as the segments show it each with a theta of its own; 1 where it is less than stated.
template <class S>
S noise_of(const SegmentInformation<S>* const* segment, int count) {
  S chi2 = S(0), dof = S(0);
  for (int i = 0; i < count; ++i) {
    chi2 += segment[i]->rho2();
    dof += S(segment[i]->dof - segment[i]->n_theta);
  }
  return dof > S(0) && chi2 > dof ? chi2 / dof : S(1);
}

}  // namespace SEGCAL_NS
