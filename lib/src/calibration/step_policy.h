// Levenberg-Marquardt's policy: whether a step is kept, how much
// the next one is damped, and when nothing is left to gain.
#pragma once

#include "calibration/calibration_fit.h"
#include "math/types.h"
#include "sensors/calibration.h"

namespace SEGCAL_NS {

template <class S>
class StepPolicy {
 public:
  void begin(S cost) {
    cost_ = cost;
    damping_ = S(0);
    flat_ = kept_ = refused_ = false;
    stalls_ = 0;
    for (S& s : last_step_) s = S(0);
  }

  /// Square root of Levenberg-Marquardt's lambda; 0 for none.
  S damping() const { return damping_; }
  /// Of the last step that was kept.
  S cost() const { return cost_; }

  /// Judges a step of theta's n entries by the cost after it. `fall`: what it should gain, by the linear system (twice
  /// that of the cost); `sigma`: of the prior. True when nothing is left to gain; kept() says whether the step stays.
  bool judge(S trial, S fall, const S* step, int n, const S* sigma, const CalibratorOptions& options) {
    // Near the minimum the difference drowns in the rounding of the sum.
    const S rounding = (std::is_same_v<S, float> ? S(2e-6) : S(1e-13)) * cost_;
    // A damped one should gain little wherever it starts.
    const bool whole = !(damping_ > S(0));
    // Where a damped one should gain less than rounding, the cost says nothing: the next is a whole one again.
    const bool lost = !whole && fall < rounding;
    kept_ = trial <= cost_ + rounding;
    if (!kept_) {
      // Neither a whole step from here nor a damped one: both would be asked in turn for ever.
      if (lost && refused_) return true;
      refused_ = refused_ || whole;
      if (whole) whole_fall_ = fall;
      damping_ = lost ? S(0) : whole ? kLeastDamping : damping_ * S(4);
      // A step that should gain less than this, and gains nothing,
      // has met the rounding: damping it cannot help.
      return (whole && fall < S(options.converged)) || damping_ > S(1e4);
    }
    flat_ = cost_ - trial <= S(1e-3) * cost_;
    stalls_ = stalls(fall, options) ? stalls_ + 1 : 0;
    refused_ = false;
    cost_ = trial;
    // An undamped step that should gain less than this is turned back by rounding.
    if (turned_back(step, n, sigma) && (!whole || fall > S(options.converged))) {
      damping_ = whole ? kLeastDamping : damping_ * S(2);
    } else {
      damping_ = damping_ < S(0.008) ? S(0) : damping_ * S(0.2);
    }
    if (lost) damping_ = S(0);
    return (whole && flat_ && fall < S(options.settled)) || stalls_ == 2;
  }
  bool kept() const { return kept_; }
  /// `left`: what an undamped step from where the last kept one led should gain.
  bool converged(S left, const CalibratorOptions& options) const {
    return left < S(options.converged) || (flat_ && left < S(options.swings));
  }

 private:
  static constexpr S kLeastDamping = S(0.01);

  /// True if this step, damped as little as possible, was kept and hardly moves theta, where a whole one would hardly
  /// move it either and costs: what is left to gain are places of landmarks along weak directions. Twice in a row, it
  /// would go on so to the last iteration.
  bool stalls(S fall, const CalibratorOptions& options) const {
    return refused_ && flat_ && damping_ <= kLeastDamping && fall < S(options.converged) &&
           whole_fall_ < S(options.swings);
  }

  /// True if this step goes against the last one (by more than 120 deg): undamped steps
  /// swing about the minimum along weak directions, such as place against inverse
  /// distance when there is hardly any parallax. Keeps the step for the next time.
  bool turned_back(const S* step, int n, const S* sigma) {
    S along = S(0), now = S(0), before = S(0);
    for (int i = 0; i < n; ++i) {
      const S a = step[i] / sigma[i], b = last_step_[i];
      along += a * b;
      now += a * a;
      before += b * b;
      last_step_[i] = a;
    }
    return along < S(0) && along * along > S(0.25) * now * before;
  }

  S damping_, cost_;
  S last_step_[kMaxTheta];  ///< in the prior's sigmas
  bool flat_ = false, kept_ = false;
  bool refused_ = false;  ///< a whole step was, from where the last kept one led
  S whole_fall_ = S(0);   ///< what that one should have gained
  int stalls_ = 0;        ///< in a row
};

}  // namespace SEGCAL_NS
