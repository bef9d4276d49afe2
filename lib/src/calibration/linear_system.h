// Calibrator: everything linearised and eliminated to ties and theta, and a step of these carried back to all states.
#pragma once

#include "calibration/calibrator.h"

namespace SEGCAL_NS {

/// Part of a tie's inverse depth's information that is prior, as LandmarkFit has it for other landmarks.
template <class S>
S Calibrator<S>::tie_prior_share(int t) const {
  S data[packed_size(kLandmarkColumns)];
  PackedTriangle<S> R(data, kLandmarkColumns);
  R.clear();
  for (int i = 0; i < count_; ++i) {
    const int j = partitions_.ties().landmark(t, i);
    if (j >= 0) fold_landmark(*segment_[i], j, theta_, model_, &R);
  }
  const S sigma = model_.depth_sigma(tie(t).rho, false);
  const S prior = S(1) / (sigma * sigma);
  return prior / (R(2, 2) * R(2, 2) + prior);
}

template <class S>
bool Calibrator<S>::linearise_step(SegmentEliminator<S>* eliminator, S damping, const CandidateTerms* candidates,
                                   bool with_prior) {
  PackedTriangle<S> G = global_.triangle();
  SEGCAL_SLICES(inner_place_) {
    G = begin_linearisation(damping, candidates, with_prior);
    for (i_ = 0; i_ < partitions_.ties().count(); ++i_) {
      fit_.dof -= S(kLandmarkColumns) - tie_prior_share(i_);
      SEGCAL_PAUSE(inner_place_);
    }
    eliminator->restart();
    for (i_ = 0; i_ < count_; ++i_) {
      segment_[i_]->turned_only = !translation_shows(*segment_[i_], theta_, model_);
      SEGCAL_PAUSE(inner_place_);
      SEGCAL_AWAIT(inner_place_,
                   eliminator->eliminate_step(*segment_[i_], guest(i_), theta_, model_, damping, candidates));
      if (running_ && i_ < count_ - 1) kept_.keep(i_, eliminator);  // the last one is there when the way back begins
      SEGCAL_AWAIT(inner_place_, chain().add_step(eliminator, link_[i_].join != Join::none, link_[i_].passes_on,
                                                  candidates ? nullptr : memory_.left(i_), &G));
      fit_.image_points += eliminator->counts().image_points;
      fit_.dof += S(eliminator->counts().residuals - eliminator->counts().unknowns) + eliminator->prior_share();
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

/// Priors and damping of what is not any segment's, and theta's degrees of freedom.
template <class S>
PackedTriangle<S> Calibrator<S>::begin_linearisation(S damping, const CandidateTerms* candidates, bool with_prior) {
  const int ties = partitions_.ties().count();
  kept_.forget_triangles();
  global_.begin(ties, theta_.columns() + (candidates ? candidates->count() : 0));
  global_.triangle().clear();
  if (with_prior) global_.clear_to_prior(*prior_, theta_, damping);
  for (int t = 0; t < ties; ++t) global_.add_tie(t, tie(t), model_, damping);
  work_.template begin<Chain<S>>().begin(global_.columns());
  const bool with_epochs = kEpochs > 0 && with_prior && epochs_ && epochs_->count() > 0;
  fit_.image_points = 0;
  fit_.dof = count_ > 0 || with_epochs ? -S(theta_.columns()) : S(0);
  if (with_epochs) {
    PackedTriangle<S> T = theta_triangle();
    epochs_->fold_into(theta_, &T);
    fit_.dof += epochs_->dof();
    fit_.image_points = epochs_->image_points();
  }
  return global_.triangle();
}

template <class S>
S Calibrator<S>::rows_of(const bool* use, const CandidateTerms& candidates, SegmentEliminator<S>* eliminator) {
  Segment<S>* all[kMaxSegments];
  bool turned_only[kMaxSegments];
  const int count = count_;
  const CalibrationFit<S> fit = fit_;
  saved_theta_ = theta_;
  memory_.begin();
  running_ = false;
  for (int i = 0; i < count; ++i) save_states(i);  // ties of other partitions give landmarks other values
  count_ = 0;
  for (int i = 0; i < count; ++i) {
    all[i] = segment_[i];
    turned_only[i] = all[i]->turned_only;
    if (use[i]) segment_[count_++] = all[i];
  }
  link_up();
  linearise(eliminator, S(0), &candidates, false);
  const S dof = count_ > 0 ? fit_.dof + S(theta_.columns()) : S(0);
  for (int i = 0; i < count; ++i) {
    segment_[i] = all[i];
    all[i]->turned_only = turned_only[i];
  }
  count_ = count;
  restore();
  link_up();
  restore();
  fit_ = fit;
  return dof;
}

/// Step of theta from the triangle, which has just been made.
template <class S>
void Calibrator<S>::solve_theta() {
  const int n = theta_.columns();
  const PackedTriangle<S> T = theta_triangle();
  fall_ = S(0);
  for (int i = 0; i < n; ++i) {
    theta_step_[i] = T(i, n);
    fall_ += T(i, n) * T(i, n);
  }
  back_substitute(T, n, theta_step_);
}

template <class S>
bool Calibrator<S>::step_back_step(SegmentEliminator<S>* eliminator, S damping) {
  SEGCAL_SLICES(inner_place_) {
    eliminator->restart();
    global_step_ = global_.solve_ties(theta_step_);
    for (S& s : guest_step_) s = S(0);
    for (i_ = count_ - 1; i_ >= 0; --i_) {
      // The step that the segment after this one found for our last keyframe; none hangs on it: none is known.
      for (int c = 0; c < kStateColumns; ++c) last_keyframe_step_[c] = link_[i_].passes_on ? guest_step_[c] : S(0);
      if (i_ < count_ - 1) {  // linearise_step() ended with the last one
        if (kept_.triangle(i_)) {
          eliminator->return_to(kept_.triangle(i_), *segment_[i_], guest(i_), theta_);
        } else {
          SEGCAL_AWAIT(inner_place_, eliminator->eliminate_step(*segment_[i_], guest(i_), theta_, model_, damping));
        }
      }
      if (link_[i_].join != Join::none) {
        SEGCAL_AWAIT(inner_place_, chain().solve_guest_step(eliminator, link_[i_].passes_on, *memory_.left(i_),
                                                            last_keyframe_step_, global_step_, guest_step_));
        SEGCAL_PAUSE(inner_place_);
      }
      gather_step(*eliminator, i_);
      SEGCAL_AWAIT(inner_place_, eliminator->back_substitute_step(
                                     *segment_[i_], guest(i_), theta_, model_, damping, step_,
                                     link_[i_].passes_on ? eliminator->last_column() : eliminator->guest_column()));
      save_states(i_);
      SEGCAL_AWAIT(inner_place_, eliminator->move_step(segment_[i_], theta_, model_, damping, step_));
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

/// What is known of segment i's step: its last keyframe, guest, theta and ties.
template <class S>
void Calibrator<S>::gather_step(const SegmentEliminator<S>& eliminator, int i) {
  const TiedLandmarks tied = guest(i).tied;
  for (int c = 0; c < kStateColumns; ++c) {
    step_[eliminator.last_column() + c] = last_keyframe_step_[c];
    if (link_[i].join != Join::none) step_[eliminator.guest_column() + c] = guest_step_[c];
  }
  for (int c = 0; c < theta_.columns(); ++c) step_[eliminator.theta_column() + c] = theta_step_[c];
  for (int c = 0; c < kLandmarkColumns * tied.n; ++c) {
    step_[eliminator.tie_column() + c] =
        global_step_[kLandmarkColumns * tied.number[c / kLandmarkColumns] + c % kLandmarkColumns];
  }
}

}  // namespace SEGCAL_NS
