// SegmentEliminator: from a step of theta, the guest and the last
// keyframe to the step of all that was eliminated, and along it.
#pragma once

#include "segments/elimination.h"

namespace SEGCAL_NS {

template <class S>
void SegmentEliminator<S>::return_to(const S* above_theta, const Segment<S>& segment, const GuestLink<S>& guest,
                                     const Calibration<S>& theta) {
  lay_out(segment, guest, theta, nullptr);
  copy_numbers(above_theta, reduced_.numbers_above_theta(), reduced_.numbers());
}

/// Puts a step into the reduced layout: poses, last keyframe, guest, theta.
template <class S>
void SegmentEliminator<S>::spread_step(const S* step) {
  const ReducedLayout& at = layout();
  for (int c = 0; c < at.last(); ++c) step_[c] = step[kStateColumns * (c / kPoseColumns) + c % kPoseColumns];
  spread_linked(step);
}

/// Last keyframe, guest, theta and ties of a step.
template <class S>
void SegmentEliminator<S>::spread_linked(const S* step) {
  const ReducedLayout& at = layout();
  for (int c = at.last(); c < at.theta(); ++c) step_[c] = step[last_column() + c - at.last()];
  const S* theta = step + theta_column();
  for (int c = 0; c < at.wide_theta(); ++c) step_[at.column_of(c)] = theta[c];
  for (int c = 0; c < kLandmarkColumns * at.tied.n; ++c) step_[at.tie(0) + c] = step[tie_column() + c];
}

template <class S>
bool SegmentEliminator<S>::back_substitute_step(const Segment<S>& segment, const GuestLink<S>& guest,
                                                const Calibration<S>& theta, const MeasurementModel<S>& model,
                                                S damping, S* step, int known) {
  const ReducedLayout& at = layout();
  SEGCAL_SLICES(place_) {
    spread_linked(step);
    reduced_.back_substitute(step_, at.last() + known - last_column());
    for (int c = 0; c < at.last(); ++c) step[kStateColumns * (c / kPoseColumns) + c % kPoseColumns] = step_[c];
    for (int c = 0; c < kStateColumns; ++c) step[last_column() + c] = step_[at.last() + c];
    work_.template begin<Linked>().chain.begin(step_, at, reduced_.numbers());  // the triangle has told what it knows
    SEGCAL_PAUSE(place_);
    SEGCAL_AWAIT(place_, run_chain_step(segment, guest, theta, model, damping));
    linked().chain.back_substitute(step + kPoseColumns, kStateColumns);
  }
  SEGCAL_SLICES_END(place_);
}

template <class S>
bool SegmentEliminator<S>::move_step(Segment<S>* segment, const Calibration<S>& theta, const MeasurementModel<S>& model,
                                     S damping, const S* step) {
  SEGCAL_SLICES(place_) {
    spread_step(step);
    work_.template begin<LandmarkBlock<S>>();
    SEGCAL_PAUSE(place_);
    for (j_ = 0; j_ < segment->n_landmarks; ++j_) {
      move_landmark(segment, j_, theta, model, damping, step);
      SEGCAL_PAUSE(place_);
    }
    for (int k = 0; k < layout().keyframes; ++k) segment->states.x[k].add(step + kStateColumns * k);
  }
  SEGCAL_SLICES_END(place_);
}

template <class S>
void SegmentEliminator<S>::move_landmark(Segment<S>* segment, int j, const Calibration<S>& theta,
                                         const MeasurementModel<S>& model, S damping, const S* step) {
  const int tie = layout().tied.place_of(j);
  if (tie >= 0) {
    // Every segment has a copy of its own, moved by the same step: they stay equal bit by bit.
    add_step(&segment->states.landmark[j], step + tie_column() + kLandmarkColumns * tie);
    return;
  }
  LandmarkFit<S> fit =
      landmark_block().build(*segment, j, theta, model, layout(), camera_term_, damping / kTypicalLandmarkStep<S>);
  if (fit.used < 2) return;
  landmark_block().eliminate(&fit);
  S landmark_step[kLandmarkColumns];
  landmark_block().solve(step_, landmark_step);
  add_step(&segment->states.landmark[j], landmark_step);
}

}  // namespace SEGCAL_NS
