// Device: keyframes into segments, which are cut and handed over to be scored (paper, Alg. 1).
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

/// Keyframes that are less than this behind their time belong to one segment, whatever its grid: slow cameras, and
/// odometries that choose their keyframes.
constexpr std::int64_t kKeyframeGapNs = 1000000000;

/// theta for triangulation and scoring, and where a calibration starts: what the filter has come to believe of the
/// sensors (paper, Sec. IV-B: of the extrinsics), with whose states it goes. Where the start is far off, an
/// accelerometer by ten per cent, states with the calibration of the start would break every IMU link. The filter's
/// camera is the one of the present temperature.
template <class S>
Calibration<S> Device<S>::working_theta() const {
  Calibration<S> theta = theta_;
  if (odometry_.own || !odometry_.filter.initialised()) return theta;
  const Calibration<S>& filter = odometry_.filter.calibration();
  theta.imu = filter.imu;
  for (int c = 0; c < theta.n_cameras; ++c) {
    theta.camera[c] =
        has_warm_camera(theta)
            ? WarmCamera<S>(theta_.camera[c], theta.effects, imu_.history.warmth()).at_25_degC(filter.camera[c])
            : filter.camera[c];
  }
  return theta;
}

/// Keyframes stand on a grid of segment_s / keyframes, so that their mean spacing is that whatever the frame rate.
template <class S>
bool Device<S>::keyframe_due(std::int64_t t_ns) const {
  const std::int64_t half_frame = static_cast<std::int64_t>(d_.options.frame_interval_s * S(0.5e9));
  return !grid_.any || t_ns + half_frame >= grid_.next_ns;
}

/// True if the open segment ends before a keyframe at t_ns.
template <class S>
bool Device<S>::segment_complete(std::int64_t t_ns, std::int64_t spacing) {
  const std::int64_t length_ns = t_ns - builder().start_ns() + spacing / 2;
  const DeviceOptions<S>& o = d_.options;
  if (!(o.most_segment_s > S(0))) return length_ns >= std::int64_t(o.segment_s * S(1e9));
  const std::int64_t from = builder().last_keyframe_ns();
  if (imu_.history.covers(from, t_ns)) grid_.liveliness.add(imu_.history, from, t_ns);
  return ends_here(grid_.liveliness, S(length_ns) * S(1e-9), o.segment_s, o.least_segment_s, o.most_segment_s);
}

/// `state`: at the frame's time, counted from odometry_.origin.
template <class S>
void Device<S>::take_keyframe(const Frame<S>& frame, const State<S>& state) {
  const std::int64_t t_ns = frame.time_ns();
  const std::int64_t base = static_cast<std::int64_t>(d_.options.segment_s * S(1e9)) / kMaxKeyframes;
  const std::int64_t gap = 4 * (base << grid_.thinned);
  const bool late = grid_.any && t_ns > grid_.next_ns + (gap > kKeyframeGapNs ? gap : kKeyframeGapNs);
  // the images before it may have waited until it was known
  const bool behind_hole = imu_.has_hole && t_ns >= imu_.hole_ns;
  imu_.has_hole = imu_.has_hole && !behind_hole;
  if (late || behind_hole) end_segment(false);
  if (!builder().empty() && segment_complete(t_ns, base << grid_.thinned)) end_segment(true);
  if (builder().full() && d_.options.most_segment_s > d_.options.segment_s) {
    builder().thin();
    ++grid_.thinned;
  }
  // A segment has one shift of stamps: after a new one was released, it begins with the first frame that came with it.
  const bool old_shift = frame.shift_ns != (odometry_.own ? 0 : stamp_shift_ns_);
  // A camera slower than the grid does not fall behind it: the grid begins anew at each of its frames.
  const bool behind = grid_.any && t_ns >= grid_.next_ns + (base << grid_.thinned);
  grid_.next_ns = (!grid_.any || behind ? t_ns : grid_.next_ns) + (base << grid_.thinned);
  grid_.any = true;
  if (builder().empty() && old_shift) return;
  if (builder().add_keyframe(t_ns, frame.shift_ns, state, odometry_.origin, frame.points, frame.n, imu_.history))
    return;
  end_segment(true);
  if (!old_shift)
    builder().add_keyframe(t_ns, frame.shift_ns, state, odometry_.origin, frame.points, frame.n, imu_.history);
}

/// Closes the open segment, hands it over to be scored, and opens the next one.
template <class S>
void Device<S>::end_segment(bool continues) {
  if (!builder().empty()) hand_over();
  begin_segment(continues);
}

/// There is memory for one segment that is scored and one that is built: if the score
/// of the one before is not done, this one is dropped. Segments too short to be
/// scored are not counted as ends: after a loss of tracking they come at any moment.
template <class S>
[[gnu::cold]] void Device<S>::hand_over() {
  ++d_.faults.segments_closed;
  if (!builder().long_enough()) {
    ++d_.faults.segments_discarded;
    return;
  }
  if (jobs_.scoring() && !at_once_) {
    ++d_.faults.slices_late;
    ++d_.faults.segments_late;
    return;
  }
  finish_start();
  jobs_.finish_score(&d_);
  if (jobs_.calibration_pending()) {
    if (jobs_.count_end(at_once_, &d_)) publish_calibration();
    return;
  }
  open_slot().frame = odometry_.frame;
  jobs_.begin_score(working_theta(), theta_, session_, &d_);
}

template <class S>
void Device<S>::begin_segment(bool continues) {
  ++serial_;
  grid_.thinned = 0;
  builder().begin(&open_slot(), session_, serial_, continues);
}

}  // namespace SEGCAL_NS
