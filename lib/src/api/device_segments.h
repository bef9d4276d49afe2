// Device: keyframes into segments, which are cut and handed over to be scored (paper, Alg. 1).
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

/// Keyframes that are less than this behind their time belong to one segment, whatever its grid: slow cameras, and
/// odometries that choose their keyframes.
constexpr std::int64_t kKeyframeGapNs = 1000000000;

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
  const std::int64_t half_frame = static_cast<std::int64_t>(d_.options.frame_interval_s * S(0.5e9));
  return !has_next_keyframe_ || t_ns + half_frame >= next_keyframe_;
}

/// True if the open segment ends before a keyframe at t_ns.
template <class S>
bool Device<S>::segment_complete(std::int64_t t_ns, std::int64_t spacing) {
  const std::int64_t length_ns = t_ns - builder().start_ns() + spacing / 2;
  const DeviceOptions<S>& o = d_.options;
  if (!(o.most_segment_s > S(0))) return length_ns >= std::int64_t(o.segment_s * S(1e9));
  const std::int64_t from = builder().last_keyframe_ns();
  if (imu_.covers(from, t_ns)) liveliness_.add(imu_, from, t_ns);
  return ends_here(liveliness_, S(length_ns) * S(1e-9), o.segment_s, o.least_segment_s, o.most_segment_s);
}

/// `state`: at the frame's time, counted from origin_.
template <class S>
void Device<S>::take_keyframe(const Frame<S>& frame, const State<S>& state) {
  const std::int64_t t_ns = frame.time_ns();
  const std::int64_t base = static_cast<std::int64_t>(d_.options.segment_s * S(1e9)) / kMaxKeyframes;
  const std::int64_t gap = 4 * (base << thinned_);
  const bool late = has_next_keyframe_ && t_ns > next_keyframe_ + (gap > kKeyframeGapNs ? gap : kKeyframeGapNs);
  const bool behind_hole = has_hole_ && t_ns >= hole_ns_;  // the images before it may have waited until it was known
  has_hole_ = has_hole_ && !behind_hole;
  if (late || behind_hole) end_segment(false);
  if (!builder().empty() && segment_complete(t_ns, base << thinned_)) end_segment(true);
  if (builder().full() && d_.options.most_segment_s > d_.options.segment_s) {
    builder().thin();
    ++thinned_;
  }
  // A segment has one shift of stamps: after a new one was released, it begins with the first frame that came with it.
  const bool old_shift = frame.shift_ns != (own_odometry_ ? 0 : stamp_shift_ns_);
  // A camera slower than the grid does not fall behind it: the grid begins anew at each of its frames.
  const bool behind = has_next_keyframe_ && t_ns >= next_keyframe_ + (base << thinned_);
  next_keyframe_ = (!has_next_keyframe_ || behind ? t_ns : next_keyframe_) + (base << thinned_);
  has_next_keyframe_ = true;
  if (builder().empty() && old_shift) return;
  if (builder().add_keyframe(t_ns, frame.shift_ns, state, origin_, frame.points, frame.n, imu_)) return;
  end_segment(true);
  if (!old_shift) builder().add_keyframe(t_ns, frame.shift_ns, state, origin_, frame.points, frame.n, imu_);
}

/// Closes the open segment, hands it over to be scored, and opens the next one.
template <class S>
void Device<S>::end_segment(bool continues) {
  if (!builder().empty()) hand_over();
  begin_segment(continues);
}

/// There is memory for one segment that is scored and one that is built: if the score of the one before is not done,
/// this one is dropped. While a calibration is under way the database is closed, and when its window is over it takes
/// effect at the first end at which it is done. Segments too short to be scored are not counted as ends: after a loss
/// of tracking they come at any moment.
template <class S>
[[gnu::cold]] void Device<S>::hand_over() {
  ++d_.faults.segments_closed;
  if (!builder().long_enough()) {
    ++d_.faults.segments_discarded;
    return;
  }
  if (score_.active() && !at_once_) {
    ++d_.faults.slices_late;
    ++d_.faults.segments_late;
    return;
  }
  finish_score();
  if (window_ == 0) {
    open_slot().frame = frame_;
    finished_ = false;
    wanted_then_ = wanted_;
    wanted_ = false;
    if constexpr (kEpochs > 0) {
      if (condensing_ && new_epoch_) d_.epochs.begin(theta_, session_);
    }
    new_epoch_ = new_epoch_ && !condensing_;
    const S scale = report_.release.noise_scale;
    spare_ = score_.begin(working_theta(), {condensing_, misfits_ + 1 >= kMostMisfits, scale * scale}, &d_);
    return;
  }
  ++d_.faults.segments_missed;
  if (window_ > 1) {
    --window_;
  } else if (calibration_.working() && !at_once_) {
    ++d_.faults.slices_late;
  } else {
    publish_calibration();
  }
}

template <class S>
void Device<S>::begin_segment(bool continues) {
  ++serial_;
  thinned_ = 0;
  builder().begin(&open_slot(), session_, serial_, continues);
}

}  // namespace SEGCAL_NS
