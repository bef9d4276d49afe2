// Calibrator: steps until nothing is left to gain, each kept if the cost falls.
#pragma once

#include "calibration/calibrator.h"

namespace SEGCAL_NS {

template <class S>
bool Calibrator<S>::total_cost_step() {
  SEGCAL_SLICES(inner_place_) {
    total_ = prior_cost(*prior_, theta_);
    if (kEpochs > 0 && epochs_) total_ += epochs_->cost(theta_);
    for (int t = 0; t < partitions_.ties().count(); ++t)
      total_ += inverse_depth_cost(tie(t), model_.inverse_depth_sigma);
    lend_cost_steps();
    for (i_ = 0; i_ < count_; ++i_) {
      SEGCAL_AWAIT(inner_place_, work_.cost.step(*segment_[i_], guest(i_), theta_, model_));
      total_ += work_.cost.total();
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

/// Each landmark to its best place given the new poses and theta: what is most curved in the problem, the inverse
/// distances of landmarks with little parallax, no longer limits the step (Golub and Pereyra's variable projection).
/// Ties have moved with theta: several segments see them.
template <class S>
bool Calibrator<S>::refine_landmarks_step() {
  SEGCAL_SLICES(inner_place_) {
    for (i_ = 0; i_ < count_; ++i_) {
      for (j_ = 0; j_ < segment_[i_]->n_landmarks; ++j_) {
        if (guest(i_).tied.place_of(j_) >= 0) continue;
        refine_landmark(*segment_[i_], j_, theta_, model_, 2, &segment_[i_]->states.landmark[j_]);
        SEGCAL_PAUSE(inner_place_);
      }
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

/// True if this step goes against the last one (by more than 120 deg): undamped steps swing about the minimum along
/// weak directions, such as place against inverse distance when there is hardly any parallax. Keeps the step for the
/// next time.
template <class S>
bool Calibrator<S>::turned_back(const S* theta_step) {
  S along = S(0), now = S(0), before = S(0);
  for (int i = 0; i < theta_.columns(); ++i) {
    const S a = theta_step[i] / prior_->sigma[i], b = last_step_[i];
    along += a * b;
    now += a * a;
    before += b * b;
    last_step_[i] = a;
  }
  return along < S(0) && along * along > S(0.25) * now * before;
}

/// One step: kept if the cost falls, taken back and damped more if not. When it is done, settled_ says whether nothing
/// is left to gain.
template <class S>
bool Calibrator<S>::iterate_step(SegmentEliminator<S>* eliminator, const CalibratorOptions& options) {
  SEGCAL_SLICES(iterate_place_) {
    SEGCAL_AWAIT(iterate_place_, linearise_step(eliminator, damping_));
    solve_theta();
    saved_theta_ = theta_;
    SEGCAL_PAUSE(iterate_place_);
    SEGCAL_AWAIT(iterate_place_, step_back_step(eliminator, damping_));
    add_step(&theta_, theta_step_);
    SEGCAL_AWAIT(iterate_place_, refine_landmarks_step());
    SEGCAL_AWAIT(iterate_place_, total_cost_step());
    settled_ = judge_step(total_, options);
  }
  SEGCAL_SLICES_END(iterate_place_);
}

template <class S>
bool Calibrator<S>::judge_step(S trial, const CalibratorOptions& options) {
  // Near the minimum the difference drowns in the rounding of the sum.
  const S rounding = (std::is_same_v<S, float> ? S(2e-6) : S(1e-13)) * cost_;
  if (!(trial <= cost_ + rounding)) {
    restore();
    damping_ = damping_ > S(0) ? damping_ * S(4) : S(0.05);
    // A step that should gain less than this, and gains nothing, has met the rounding: damping it further cannot help.
    const bool done = fall_ < S(options.converged) || damping_ > S(1e4);
    if (done) fit_.converged = true;
    return done;
  }
  flat_ = cost_ - trial <= S(1e-3) * cost_;
  if (flat_ && fall_ < S(options.converged)) fit_.converged = true;
  cost_ = trial;
  if (turned_back(theta_step_)) {
    damping_ = damping_ > S(0) ? damping_ * S(2) : S(0.05);
  } else {
    damping_ = damping_ < S(0.05) ? S(0) : damping_ * S(0.2);
  }
  return flat_ && fall_ < S(options.settled);
}

template <class S>
bool Calibrator<S>::run_step(const CalibratorOptions& options, SegmentEliminator<S>* eliminator) {
  SEGCAL_SLICES(place_) {
    damping_ = S(0);
    SEGCAL_AWAIT(place_, total_cost_step());
    cost_ = fit_.start_cost = total_;
    fit_.converged = settled_ = flat_ = false;
    for (S& s : last_step_) s = S(0);
    for (fit_.iterations = 0; fit_.iterations < options.max_iterations && !settled_; ++fit_.iterations) {
      SEGCAL_AWAIT(place_, iterate_step(eliminator, options));
    }
    fit_.cost = cost_;
    fit_.converged = fit_.converged || (flat_ && fall_ < S(options.swings));
    SEGCAL_AWAIT(place_, linearise_step(eliminator, S(0)));
    set_chi2();
  }
  SEGCAL_SLICES_END(place_);
}

}  // namespace SEGCAL_NS
