// Score tests on the device: what all segments scored since the last calibration say about the effects that are watched
// (score_test.h), as one triangle over [theta | watched terms | rhs] with theta's prior.
//
// Each segment counts alone, at the theta it was scored with. Its rows speak of a step from there; they are moved to
// the theta that the triangle began with, which is exact as far as they are linear. The segment's states are the
// filter's, not fitted: a strong statistic is a suspicion, for the host's diagnosis to confirm.
#pragma once

#include "calibration/prior.h"
#include "diagnosis/score_test.h"
#include "segments/elimination.h"
#include "sensors/effect_catalogue.h"

namespace SEGCAL_NS {

template <class S>
class EffectMonitor {
 public:
  /// `watch`: bit e for effect e. False if they need more columns than there are.
  bool begin(std::uint32_t watch, const ThetaPrior<S>& prior, const Calibration<S>& theta) {
    terms_.n = 0;
    for (int e = 0; e < kEffects; ++e) {
      group_[e] = TermGroup{};
      if (!(watch >> e & 1u) || theta.effects.place_of(effect_term(e, 0)) >= 0) continue;
      const int n = effect_entry(e).n;
      if (theta.effects.count() + terms_.n + n > kMaxEffectColumns) return false;
      group_[e] = {terms_.n, n};
      for (int i = 0; i < n; ++i) terms_.term[terms_.n++] = effect_term(e, i);
    }
    reset(prior, theta);
    return true;
  }

  /// Forgets all segments.
  void reset(const ThetaPrior<S>& prior, const Calibration<S>& theta) {
    if (!active()) return;
    reference_ = theta;
    n_theta_ = theta.columns();
    segments_ = 0;
    dof_ = S(0);
    PackedTriangle<S> T = triangle();
    write_prior(prior, theta, &T);
  }

  bool active() const { return terms_.count() > 0; }
  /// Columns for the elimination; null without any.
  const CandidateTerms* candidates() const { return active() ? &terms_ : nullptr; }

  /// Takes the segment that was just eliminated at `theta` with candidates().
  void add(SegmentEliminator<S>* segment, const Calibration<S>& theta) {
    if (!active()) return;
    const int n = n_theta_ + terms_.n;
    S offset[kMaxTheta], row[kMaxWideTheta + 1];
    difference(reference_, theta, offset);
    PackedTriangle<S> T = triangle();
    for (int i = 0; i <= n; ++i) {
      const S* from = segment->wide_row(i);
      for (int c = 0; c <= n; ++c) row[c] = from[c];
      for (int c = 0; c < n_theta_; ++c) row[n] += from[c] * offset[c];
      fold_rows(T, row, 1, n + 1, 0, n + 1);
    }
    ++segments_;
    dof_ += S(segment->counts().residuals - segment->counts().unknowns) + segment->prior_share();
  }

  int segments() const { return segments_; }
  int parameters(int effect) const { return group_[effect].count; }
  /// chi2/dof with all terms free.
  S chi2_per_dof() {
    const S rho = triangle()(n_theta_ + terms_.n, n_theta_ + terms_.n), dof = dof_ - S(terms_.n);
    return dof > S(0) ? rho * rho / dof : S(0);
  }
  /// Of a watched effect, the others held at zero.
  EffectScore<S> score(int effect) {
    const PackedTriangle<S> T = triangle();
    return ScoreTest<S>(T, n_theta_, scratch_).of(group_[effect]);
  }

 private:
  PackedTriangle<S> triangle() { return PackedTriangle<S>(data_, n_theta_ + terms_.n + 1); }

  CandidateTerms terms_;
  TermGroup group_[kEffects];
  Calibration<S> reference_;
  std::int32_t n_theta_ = 0, segments_ = 0;
  S dof_ = S(0);
  S scratch_[ScoreTest<S>::scratch_size(kMaxEffectColumns)];  ///< of its own: it is asked while others work
  S data_[kMaxEffectColumns > 0 ? packed_size(kMaxWideTheta + 1) : packed_size(kMaxTheta + 1)];
};

}  // namespace SEGCAL_NS
