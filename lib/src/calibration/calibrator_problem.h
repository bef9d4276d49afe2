// Calibrator: which segments a fit is over, what joins them, and which image points take part.
#pragma once

#include "calibration/calibrator.h"

namespace SEGCAL_NS {

template <class S>
template <class Pointer>
void Calibrator<S>::begin(const Pointer* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                          const MeasurementModel<S>& model) {
  set_up(segments, count, prior, theta, model);
  link_up();
}

template <class S>
template <class Pointer>
void Calibrator<S>::continue_with(const Pointer* segments, int count, const ThetaPrior<S>& prior,
                                  const Calibration<S>& theta, const MeasurementModel<S>& model) {
  bool same = count == count_;
  for (int i = 0; i < count && same; ++i) same = segment_[i] == segments[i];
  if (same) return;
  const CalibrationFit<S> fit = fit_;
  set_up(segments, count, prior, theta, model);
  saved_theta_ = theta_;
  for (int i = 0; i < count; ++i) save_states(i);
  link_up();  // ties give landmarks other values
  restore();
  fit_ = fit;
}

template <class S>
template <class Pointer>
void Calibrator<S>::set_up(const Pointer* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                           const MeasurementModel<S>& model) {
  count_ = count;
  prior_ = &prior;
  epochs_ = nullptr;
  theta_ = theta;
  model_ = model;
  fit_ = CalibrationFit<S>{};
  place_ = iterate_place_ = inner_place_ = 0;
  memory_.begin();
  kept_.begin();
  running_ = false;
  for (int i = 0; i < count; ++i) segment_[i] = segments[i];
}

template <class S>
void Calibrator<S>::link_up() {
  for (int i = 0; i < count_; ++i) {
    link_[i] = i > 0 ? link_after(end_of(*segment_[i - 1]), *segment_[i]) : SegmentLink<S>{};
    if (i > 0) link_[i - 1].passes_on = link_[i].join != Join::none;
  }
  form_partitions();
}

template <class S>
void Calibrator<S>::form_partitions() {
  Segment<S>* segment[kMaxSegments];
  for (int i = 0; i < count_; ++i) segment[i] = segment_[i];
  partitions_.form(segment, link_, count_, theta_, model_);
  partition_count_ = partitions_.count();
}

template <class S>
GuestLink<S> Calibrator<S>::guest(int i) {
  GuestLink<S> g;
  g.join = link_[i].join;
  g.gap_s = link_[i].gap_s;
  if (g.join != Join::none) {
    const Segment<S>& before = *segment_[i - 1];
    g.state = before.states.x[before.n_keyframes - 1];
    g.state.p_GI = segment_[i]->from_origin_of(before, g.state.p_GI);
  }
  g.hangs = !partitions_.is_first(i);
  partitions_.ties().of_segment(i, &g.tied);
  if (running_) g.kept = kept_.links(i);
  return g;
}

template <class S>
const Landmark<S>& Calibrator<S>::tie(int t) const {
  const int i = partitions_.ties().first_segment(t);
  return segment_[i]->states.landmark[partitions_.ties().landmark(t, i)];
}

template <class S>
void Calibrator<S>::restore() {
  theta_ = saved_theta_;
  for (int i = 0; i < count_; ++i) segment_[i]->states = memory_.saved(i);
}

template <class S>
bool Calibrator<S>::reject_outliers_step(S limit) {
  const S ratio = fit_.dof > S(0) ? fit_.chi2 / fit_.dof : S(1);
  const S scaled = limit * square_root(ratio > S(1) ? ratio : S(1));
  SEGCAL_SLICES(place_) {
    for (i_ = 0; i_ < count_; ++i_) {
      for (j_ = 0; j_ < segment_[i_]->n_landmarks; j_ += kLandmarksPerSlice) {
        mark_outliers(theta_, model_, scaled, j_, j_ + kLandmarksPerSlice, segment_[i_].get());
        SEGCAL_PAUSE(place_);
      }
      segment_[i_]->wide_depth_prior = !translation_shows(*segment_[i_], theta_, model_);
      SEGCAL_PAUSE(place_);
    }
    form_partitions();  // without a tie whose points are gone
  }
  SEGCAL_SLICES_END(place_);
}

template <class S>
void Calibrator<S>::accept_all() {
  for (int i = 0; i < count_; ++i) {
    segment_[i]->wide_depth_prior = true;
    for (int o = 0; o < segment_[i]->n_observations; ++o) segment_[i]->observation[o].rejected = 0;
  }
  form_partitions();
}

}  // namespace SEGCAL_NS
