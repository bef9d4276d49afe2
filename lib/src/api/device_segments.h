// Device: keyframes into segments, which are cut, scored and offered to the database (paper, Alg. 1).
#pragma once

#include "api/device.h"
#include "math/resumable.h"

namespace SEGCAL_NS {

/// theta for triangulation and scoring: the extrinsics are the filter's (paper, Sec. IV-B).
template <class S>
Calibration<S> Device<S>::working_theta() const {
  Calibration<S> theta = theta_;
  if (own_odometry_ || !vio_.initialised()) return theta;
  for (int c = 0; c < theta.n_cameras; ++c) {
    theta.camera[c].R_CI = vio_.R_CI(c);
    theta.camera[c].p_CI = vio_.p_CI(c);
  }
  return theta;
}

/// Keyframes stand on a grid of segment_s / keyframes, so that their mean spacing is that whatever the frame rate.
template <class S>
bool Device<S>::keyframe_due(std::int64_t t_ns) const {
  const std::int64_t half_frame = static_cast<std::int64_t>(options_.frame_interval_s * S(0.5e9));
  return next_keyframe_ == kNever || t_ns + half_frame >= next_keyframe_;
}

/// True if the open segment ends before a keyframe at t_ns.
template <class S>
bool Device<S>::segment_complete(std::int64_t t_ns, std::int64_t spacing) {
  const std::int64_t length_ns = t_ns - builder_.start_ns() + spacing / 2;
  if (!(options_.most_segment_s > S(0))) return length_ns >= std::int64_t(options_.segment_s * S(1e9));
  const std::int64_t from = builder_.last_keyframe_ns();
  if (imu_.covers(from, t_ns)) liveliness_.add(imu_, from, t_ns);
  return ends_here(liveliness_, S(length_ns) * S(1e-9), options_.segment_s, options_.least_segment_s, options_.most_segment_s);
}

template <class S>
void Device<S>::take_keyframe(std::int64_t t_ns, const State<S>& state, const TrackPoint<S>* points, int n) {
  const std::int64_t base = static_cast<std::int64_t>(options_.segment_s * S(1e9)) / kMaxKeyframes;
  const bool late = next_keyframe_ != kNever && t_ns > next_keyframe_ + 4 * (base << thinned_);
  if (late) end_segment(false);
  if (!builder_.empty() && segment_complete(t_ns, base << thinned_)) end_segment(true);
  if (builder_.full() && options_.most_segment_s > options_.segment_s) {
    builder_.thin();
    ++thinned_;
  }
  next_keyframe_ = (next_keyframe_ == kNever || late ? t_ns : next_keyframe_) + (base << thinned_);
  const auto shift_ns = [this] { return own_odometry_ ? 0 : stamp_shift_ns_; };
  if (builder_.add_keyframe(t_ns, shift_ns(), state, points, n, imu_)) return;
  end_segment(true);
  builder_.add_keyframe(t_ns, shift_ns(), state, points, n, imu_);
}

/// Closes the open segment, hands it over to be scored, and opens the next one. The score of the segment before must be done
/// by then; and while a calibration is under way the database is closed.
template <class S>
void Device<S>::end_segment(bool continues) {
  if (!builder_.empty()) {
    if (scoring_) ++faults_.slices_late;
    finish_score();
    ++faults_.segments_closed;
    open_slot().frame = frame_;
    if (window_ > 0) {
      ++faults_.segments_missed;
      if (--window_ == 0) {
        if (calibrating_) ++faults_.slices_late;
        finish_calibration();
      }
    } else if (builder_.long_enough()) {
      begin_score();
    } else {
      ++faults_.segments_discarded;
    }
  }
  ++serial_;
  thinned_ = 0;
  builder_.begin(&open_slot(), session_, serial_, continues);
}

/// The closed segment stays in its slot; the next one begins in memory that only a calibration needs.
template <class S>
void Device<S>::begin_score() {
  scoring_ = true;
  score_place_ = 0;
  known_theta_ = working_theta();
  spare_ = calibrator_.lend_segment();
  builder_.restart_close();
  eliminator_.restart();
  calibrator_.lend_cost_steps();
  largest_.restart();
}

template <class S>
bool Device<S>::score_step() {
  Segment<S>& segment = database_.building();
  SEGCAL_SLICES(score_place_) {
    SEGCAL_AWAIT(score_place_, builder_.close_step(&segment, known_theta_, options_.model));
    if (SegmentBuilder<S>::useful(segment)) {
      SEGCAL_PAUSE(score_place_);
      segment.turned_only = segment.wide_depth_prior = !translation_shows(segment, known_theta_, options_.model);
      SEGCAL_PAUSE(score_place_);
      SEGCAL_AWAIT(score_place_, eliminator_.eliminate_step(segment, GuestLink<S>{}, known_theta_, options_.model, S(0),
                                                            monitor_.candidates()));
      SEGCAL_PAUSE(score_place_);
      eliminator_.extract(&segment.information);
      SEGCAL_PAUSE(score_place_);
      begin_analysis(segment.information, prior().sigma, &analysis_);
      SEGCAL_AWAIT(score_place_, analyse_step(segment.information.n_theta, &analysis_));
      segment.metrics = metrics_but_E(&analysis_, prior().sigma, options_.sigma_ref);
      SEGCAL_AWAIT(score_place_, largest_.step(analysis_.W, analysis_.n));
      segment.metrics.E = largest_.value();
      SEGCAL_AWAIT(score_place_, calibrator_.cost_steps().inertial_step(segment, GuestLink<S>{}, known_theta_, options_.model));
      SEGCAL_PAUSE(score_place_);
      settle(segment);
      SEGCAL_PAUSE(score_place_);
      sums_ = joint_information();
      if (settled_) {
        SEGCAL_AWAIT(score_place_, database_.compare_step(&sums_));
        last_.kept = database_.offer_compared(&sums_);
        SEGCAL_PAUSE(score_place_);
      }
      end_score();
    } else {
      ++faults_.segments_discarded;
      builder_.move_to(&database_.building());
    }
  }
  SEGCAL_SLICES_END(score_place_);
}

/// Whether the scored segment may be kept; and what it says about the effects that are watched.
template <class S>
void Device<S>::settle(const Segment<S>& segment) {
  last_ = summary_of(segment);
  settled_ = follows_its_imu(segment, calibrator_.cost_steps().inertial(), known_theta_.effects.count() > 0 || monitor_.active());
  if (!settled_) ++faults_.segments_unsettled;
  if (settled_) monitor_.add(&eliminator_, known_theta_);
}

/// The open segment moves to the slot that is free now. A calibration follows if this segment was the one that was missing.
template <class S>
void Device<S>::end_score() {
  builder_.move_to(&database_.building());
  if (!last_.kept || knew_enough_ || !knows_enough()) return;
  knew_enough_ = true;
  if (!options_.calibrates_itself || options_.joint_filter) return;
  begin_calibration(known_theta_);
  window_ = kCalibrationWindow;
}

template <class S>
void Device<S>::finish_score() {
  while (scoring_) scoring_ = !score_step();
}

/// True if the kept segments are worth a calibration: there are enough (paper, Alg. 1), or, where there are targets, they
/// predict that these will be reached.
template <class S>
bool Device<S>::knows_enough() {
  if (!has_targets(options_.target_sigma, theta_.columns())) return database_.full();
  const SegmentInformation<S>* segments[kMaxSegments];
  int n = 0;
  for (int i = 0; i < Database<S>::kSlots; ++i) {
    if (database_.kept(i)) segments[n++] = &database_.slot(i).information;
  }
  JointInformation<S> joint = joint_information();
  return reaches_targets(joint.sum(segments, n), prior().sigma, options_.target_sigma, database_.full());
}

}  // namespace SEGCAL_NS
