// Device: keyframes into segments, which are cut, scored and offered to the database (paper, Alg. 1).
#pragma once

#include "api/device.h"

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
  const std::int32_t shift_ns = own_odometry_ ? 0 : stamp_shift_ns_;
  if (builder_.add_keyframe(t_ns, shift_ns, state, points, n, imu_)) return;
  end_segment(true);
  builder_.add_keyframe(t_ns, shift_ns, state, points, n, imu_);
}

/// Closes, scores and offers the open segment, then opens the next one.
template <class S>
void Device<S>::end_segment(bool continues) {
  if (!builder_.empty()) {
    ++faults_.segments_closed;
    database_.building().frame = frame_;
    if (builder_.close(working_theta(), options_.model)) {
      score();
    } else {
      ++faults_.segments_discarded;
    }
  }
  ++serial_;
  thinned_ = 0;
  builder_.begin(&database_.building(), session_, serial_, continues);
}

template <class S>
void Device<S>::score() {
  Segment<S>& segment = database_.building();
  GuestLink<S> alone;
  const Calibration<S> theta = working_theta();
  segment.turned_only = segment.wide_depth_prior = !translation_shows(segment, theta, options_.model);
  eliminator_.eliminate(segment, alone, theta, options_.model, S(0), monitor_.candidates());
  eliminator_.extract(&segment.information);
  analyse(segment.information, prior_.sigma, &analysis_);
  segment.metrics = metrics_of(&analysis_, prior_.sigma, options_.sigma_ref);
  last_ = summary_of(segment);
  const bool settled = follows_its_imu(segment, theta, options_.model, theta.effects.count() > 0 || monitor_.active());
  if (!settled) ++faults_.segments_unsettled;
  if (settled) monitor_.add(&eliminator_, theta);
  JointInformation<S> joint = joint_information();
  last_.kept = settled && database_.offer(&joint);
  if (last_.kept && !knew_enough_ && knows_enough()) {
    knew_enough_ = true;
    calibration_due_ = true;
  }
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
  return reaches_targets(joint.sum(segments, n), prior_.sigma, options_.target_sigma, database_.full());
}

}  // namespace SEGCAL_NS
