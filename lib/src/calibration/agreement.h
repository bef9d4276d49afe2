// Do segments tell of one and the same theta? A device that was dropped, or whose lens was turned, has another
// calibration than its older segments know.
//
// Segments are taken from the newest to the oldest. Each is held against the prior
// and all newer ones that agreed: with R_1 delta = d_1 from the one and R_2 delta
// = d_2 from the others, what their common least-squares solution leaves over is
//     (delta_1 - delta_2)' (Sigma_1 + Sigma_2)^-1 (delta_1 - delta_2),
// chi-square with the rank of R_1 as degrees of freedom if theta is the same and
// the model is all there is. It needs no inverse, so directions that a segment does
// not show do no harm; they are left out of R_1, where they would only add noise.
//
// No model is all there is: on real recordings neighbours of a few seconds disagree by two
// to six per degree of freedom. So the measure is what the newer ones disagree among
// themselves, at least 1, and the ratio of the two mean squares is F. One segment alone
// convicts nobody, then, and nor do several that could not stand in for what they convict.
// Two may agree by chance: the verdicts stand only if they are confirmed by all in the end.
#pragma once

#include "calibration/epochs.h"
#include "calibration/spread.h"
#include "information/marginal.h"
#include "information/metrics.h"

namespace SEGCAL_NS {

template <class S>
class Agreement {
 public:
  static constexpr int kScratch = 4 * packed_size(kMaxTheta + 1) + kMaxTheta * (kMaxTheta + 1);

  Agreement() = default;
  /// All segments' information must be linearised at `theta`. `level`: probability
  /// of a false verdict in one comparison. `noise`: variance of whitened residuals,
  /// 1 where the noise is as stated. Memory is lent; all arguments must stay.
  Agreement(const ThetaPrior<S>& prior, const Calibration<S>& theta, S level, S noise, InformationAnalysis<S>* analysis,
            S* scratch)
      : prior_(&prior),
        theta_(&theta),
        n_(theta.columns()),
        level_(level),
        noise_(noise),
        analysis_(analysis),
        scratch_(scratch) {
    begin();
  }

  /// Takes the next older segment, in slices; true when outdated()
  /// is its verdict. An outdated one says nothing to the rest.
  [[gnu::cold]] bool take_step(const SegmentInformation<S>& information) {
    SEGCAL_SLICES(place_) {
      outdated_ = false;
      if (agreed_ > 0) {
        begin_analysis(information, prior_->sigma, analysis_.get());
        SEGCAL_AWAIT(place_, analyse_step(information.n_theta, analysis_.get()));
        compare(information, copy_of(newer()));
        outdated_ = contradicted() && know_enough();
        SEGCAL_PAUSE(place_);
      }
      if (outdated_) {
        against_ += statistic_;
        against_degrees_ += degrees_;
        if (outdated_items_ >= 2) {
          add_prior(copy_of(last_outdated()));
          SEGCAL_PAUSE(place_);
          compare(information, trial());
          know_neighbours();
          SEGCAL_PAUSE(place_);
        }
        contradict(information);
        SEGCAL_PAUSE(place_);
        remember(information);
      } else {
        agree(information);
      }
    }
    SEGCAL_SLICES_END(place_);
  }
  bool outdated() const { return outdated_; }
  /// What the item that take_step() has judged is known to scatter by
  /// in itself: a sum of squares of unit variance, with `degrees`.
  void know_spread(S sum, int degrees) { (outdated_ ? spread_of_outdated_ : spread_).add(sum / noise_, degrees); }
  /// After the last one: do outdated ones contradict newer ones by more than either contradict each other? A model that
  /// lacks something makes segments disagree that no change lies between, and in few directions each (spread.h): newer
  /// ones that happen to agree convict all others then.
  bool confirmed() const {
    if (outdated_items_ == 0) return false;
    Spread<S> all = spread_;
    all.add(spread_of_outdated_);
    all.add(pending_, pending_degrees_);
    const S limit = all.uneven_limit(against_degrees_, level_, outdated_items_);
    return limit > S(0) && against_ > limit * S(against_degrees_) * all.mean();
  }
  /// After the last one: whether all that is outdated, together, contradicts all that agreed; by chance with
  /// probability p. Either may scatter more.
  [[gnu::cold]] bool changed(S p) {
    if (outdated_items_ == 0) return false;
    PackedTriangle<S> T = copy_of(newer()), older = outdated_ones();
    S* row = block();
    for (int i = 0; i < n_; ++i) {
      for (int c = 0; c <= n_; ++c) row[c] = c < i ? S(0) : older(i, c);
      fold_rows(T, row, 1, n_ + 1, i, n_ + 1);
    }
    Spread<S> both = spread_;
    both.add(spread_of_outdated_);
    const Spread<S>& spread = both.mean() > spread_.mean() ? both : spread_;
    const S limit = spread.uneven_limit(n_, p), square = T(n_, n_) * T(n_, n_) / noise_;
    return limit > S(0) && square > limit * S(n_) * spread.mean();
  }
  bool outdated(const SegmentInformation<S>& information) {
    while (!take_step(information)) {
    }
    return outdated_;
  }

 private:
  void agree(const SegmentInformation<S>& information) {
    if (agreed_ > 0) spread_.add(statistic_, degrees_);
    PackedTriangle<S> T = newer();
    add(information, &T);
    ++agreed_;
  }
  /// The newest of several may be the one in which the device changed, which tells of neither theta: it gives its place
  /// to the second.
  void contradict(const SegmentInformation<S>& information) {
    PackedTriangle<S> T = outdated_ones();
    if (outdated_items_++ < 2) T.clear();
    add(information, &T);
  }
  void remember(const SegmentInformation<S>& information) {
    PackedTriangle<S> T = last_outdated();
    T.clear();
    add(information, &T);
  }
  /// How far an outdated item is from the one before. Of two such comparisons the smaller counts: the device may have
  /// changed more than once.
  void know_neighbours() {
    if (pending_degrees_ == 0) {
      pending_ = statistic_;
      pending_degrees_ = degrees_;
      return;
    }
    const bool first = pending_ * S(degrees_) < statistic_ * S(pending_degrees_);
    spread_of_outdated_.add(first ? pending_ : statistic_, first ? pending_degrees_ : degrees_);
    pending_ = S(0);
    pending_degrees_ = 0;
  }
  PackedTriangle<S> newer() { return PackedTriangle<S>(scratch_, n_ + 1); }
  PackedTriangle<S> trial() { return PackedTriangle<S>(scratch_ + packed_size(n_ + 1), n_ + 1); }
  PackedTriangle<S> outdated_ones() { return PackedTriangle<S>(scratch_ + 2 * packed_size(n_ + 1), n_ + 1); }
  PackedTriangle<S> last_outdated() { return PackedTriangle<S>(scratch_ + 3 * packed_size(n_ + 1), n_ + 1); }
  S* block() { return scratch_ + 4 * packed_size(n_ + 1); }

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
  /// Into T, which leaves nothing over.
  void add_prior(PackedTriangle<S> T) {
    S offset[kMaxTheta], *row = block();
    difference(prior_->mean, *theta_, offset);
    for (int i = 0; i < n_; ++i) {
      for (int c = 0; c <= n_; ++c) row[c] = S(0);
      row[i] = S(1);
      row[n_] = -offset[i] / prior_->sigma[i];
      fold_rows(T, row, 1, n_ + 1, i, n_ + 1);
    }
    T.row(n_)[n_] = S(0);
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

  /// Without what it left over.
  PackedTriangle<S> copy_of(const PackedTriangle<S>& from) {
    PackedTriangle<S> T = trial();
    for (int k = 0; k < packed_size(n_ + 1); ++k) T.row(0)[k] = from.row(0)[k];
    T.row(n_)[n_] = S(0);
    return T;
  }

  /// The limit grows with how little is known about the spread.
  bool contradicted() const {
    const S limit = spread_.limit(degrees_, level_);
    return limit > S(0) && statistic_ > limit * S(degrees_) * spread_.mean();
  }

  /// `T`: a copy, which is used up.
  void compare(const SegmentInformation<S>& information, PackedTriangle<S> T) {
    degrees_ = 0;
    statistic_ = S(0);
    while (degrees_ < n_ && analysis_->relative_sigma(degrees_) < ReleaseRules<S>{}.weak)
      shown_row(information, degrees_++);
    if (degrees_ == 0) return;
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

  Near<const ThetaPrior<S>> prior_;
  Near<const Calibration<S>> theta_;
  int n_ = 0, agreed_ = 0, outdated_items_ = 0, degrees_ = 0;
  S level_ = S(0), noise_ = S(1), statistic_ = S(0);  // of the last comparison
  S against_ = S(0);                                  // of all that are outdated, each against the newer ones
  S pending_ = S(0);                                  // of two neighbours that are outdated
  int against_degrees_ = 0, pending_degrees_ = 0;
  Spread<S> spread_, spread_of_outdated_;  // of all that agreed; of each that did not, in itself
  Near<InformationAnalysis<S>> analysis_;
  Near<S> scratch_;
  Place place_ = 0;
  bool outdated_ = false;
};

}  // namespace SEGCAL_NS
