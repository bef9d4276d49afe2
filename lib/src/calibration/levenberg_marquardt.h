// Calibrator: steps until nothing is left to gain; step_policy.h decides which are kept.
#pragma once

#include "calibration/calibrator.h"

namespace SEGCAL_NS {

template <class S>
bool Calibrator<S>::total_cost_step() {
  SEGCAL_SLICES(inner_place_) {
    total_ = prior_cost(*prior_, theta_);
    if (kEpochs > 0 && epochs_) total_ += epochs_->cost(theta_);
    for (int t = 0; t < partitions_.ties().count(); ++t)
      total_ += inverse_depth_cost(tie(t), model_.depth_sigma(tie(t).rho, false));
    begin_costs();
    for (i_ = 0; i_ < count_; ++i_) {
      SEGCAL_AWAIT(inner_place_, costs().step(*segment_[i_], guest(i_), theta_, model_));
      total_ += costs().total();
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

/// One step: kept if the cost falls, taken back and damped more if not.
/// When it is done, settled_ says whether nothing is left to gain.
template <class S>
bool Calibrator<S>::iterate_step(SegmentEliminator<S>* eliminator, const CalibratorOptions& options) {
  SEGCAL_SLICES(iterate_place_) {
    SEGCAL_AWAIT(iterate_place_, linearise_step(eliminator, policy_.damping()));
    solve_theta();
    saved_theta_ = theta_;
    SEGCAL_PAUSE(iterate_place_);
    SEGCAL_AWAIT(iterate_place_, step_back_step(eliminator, policy_.damping()));
    add_step(&theta_, theta_step_);
    SEGCAL_AWAIT(iterate_place_, refine_landmarks_step());
    SEGCAL_AWAIT(iterate_place_, total_cost_step());
    settled_ = policy_.judge(total_, fall_, theta_step_, theta_.columns(), prior_->sigma, options);
    if (!policy_.kept()) restore();
  }
  SEGCAL_SLICES_END(iterate_place_);
}

template <class S>
bool Calibrator<S>::run_step(const CalibratorOptions& options, SegmentEliminator<S>* eliminator) {
  SEGCAL_SLICES(place_) {
    running_ = true;
    SEGCAL_AWAIT(place_, total_cost_step());
    fit_.start_cost = total_;
    policy_.begin(total_);
    fit_.converged = settled_ = false;
    for (fit_.iterations = 0; fit_.iterations < options.max_iterations && !settled_; ++fit_.iterations) {
      SEGCAL_AWAIT(place_, iterate_step(eliminator, options));
    }
    fit_.cost = policy_.cost();
    SEGCAL_AWAIT(place_, linearise_step(eliminator, S(0)));
    solve_theta();
    fit_.converged = policy_.converged(fall_, options);
    set_chi2();
    running_ = false;
  }
  SEGCAL_SLICES_END(place_);
}

}  // namespace SEGCAL_NS
