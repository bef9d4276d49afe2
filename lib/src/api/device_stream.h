// Device: frames on their way through the filter. Faults are counted.
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

/// Images further than this from the newest IMU sample are not
/// of its clock, ns: a FIFO or a slow driver is late by less.
constexpr std::int64_t kFarFrameNs = 2000000000;
/// No camera is faster, ns: nearer stamps say nothing about its period.
constexpr std::int64_t kShortestPeriodNs = 1000000;
/// No images are missing in a longer one: it was switched off, ns.
constexpr std::int64_t kLongestPauseNs = 3600000000000;

/// Where states come from. Two sources have two frames; the user's own frame outlives gaps in the IMU's stream.
template <class S>
[[gnu::cold]] void Device<S>::use_odometry(bool own) {
  if (own == odometry_.own) return;
  if (!builder().empty()) end_segment(false);
  odometry_.own = own;
  ++odometry_.frame;
}

/// Frames missing from an even stream. The camera's period is where the intervals lead,
/// by a sixteenth at most each time, so that a stamp that was taken late moves it little;
/// and by a 64th where an image seems to be missing, so that half of them may be.
template <class S>
[[gnu::cold]] void Device<S>::count_missing_frames(std::int64_t t_ns) {
  const std::int64_t interval = t_ns - frames_.last_ns;
  if (interval < kShortestPeriodNs || interval > kLongestPauseNs) return;
  if (frames_.period_ns == 0) frames_.period_ns = interval;
  const std::int64_t most = frames_.period_ns / 16, off = interval - frames_.period_ns;
  frames_.period_ns += off > frames_.period_ns / 2 ? most / 4 : off > most ? most : off < -most ? -most : off;
  const std::int64_t periods = (interval + frames_.period_ns / 2) / frames_.period_ns;
  if (periods > 1) d_.faults.frames_dropped += static_cast<std::uint32_t>(periods - 1);
}

/// What came before the first sample, when nothing told that its
/// stamp is far ahead: what follows must not wait for that time.
template <class S>
[[gnu::cold]] void Device<S>::forget_frames() {
  frames_.waiting.clear();
  frames_.any = frames_.any_offered = false;
  ++d_.faults.frame_stamps_far;
}

/// Counts a frame; false if its stamp is refused.
template <class S>
[[gnu::cold]] bool Device<S>::take_frame_stamp(std::int64_t t_ns) {
  ++d_.faults.frames;
  const bool in_range = t_ns <= kMostStamp && t_ns >= -kMostStamp;
  if (in_range && frames_.any && frames_.last_ns - (imu_.any ? imu_.last_ns : t_ns) > kFarFrameNs) forget_frames();
  if (!in_range || (imu_.any && (t_ns - imu_.last_ns > kFarFrameNs || imu_.last_ns - t_ns > kFarFrameNs))) {
    ++d_.faults.frame_stamps_far;
    return false;
  }
  if (frames_.any && t_ns <= frames_.last_ns) {
    ++d_.faults.frame_stamps_back;
    return false;
  }
  return true;
}

/// Puts an image where it waits for its samples; false if there is no place.
template <class S>
template <class Point>
bool Device<S>::let_wait(std::int64_t t_ns, std::int32_t shift_ns, int n, Point point) {
  if (frames_.waiting.full()) {
    ++d_.faults.frames_dropped;  // the IMU's samples are too late
    ++frames_.crowded_out;
    return false;
  }
  Frame<S>& frame = frames_.waiting.append(t_ns, shift_ns);
  const LeftOut left_out = take_points<S>(n, point, &frame);
  d_.faults.points_not_finite += left_out.not_finite;
  d_.faults.points_repeated += left_out.repeated;
  return true;
}

template <class S>
Taken Device<S>::process_frames() {
  Taken last = Taken::waiting;
  while (frame_ready()) last = process_frame();
  return frames_.waiting.empty() ? last : Taken::waiting;
}

template <class S>
template <class Point>
Taken Device<S>::push_tracks(std::int64_t t_ns, int n, Point point) {
  if (!take_frame_stamp(t_ns)) return Taken::stamp_refused;
  if (frames_.any) count_missing_frames(t_ns);
  frames_.last_ns = t_ns;
  frames_.any = true;
  // Sooner than the filter wants one: no place is taken. One millisecond of grace: stamps jitter.
  if (frames_.any_offered && S(t_ns - frames_.last_offered_ns) * S(1e-9) < d_.options.frame_interval_s - S(1e-3))
    return Taken::skipped;
  if (!let_wait(t_ns, stamp_shift_ns_, n, point)) return Taken::skipped;
  frames_.last_offered_ns = t_ns;
  frames_.any_offered = true;
  if (frames_.waiting.newest().n < kFewestTracks) ++d_.faults.frames_few_tracks;
  return process_frames();
}

/// The front one.
template <class S>
Taken Device<S>::process_frame() {
  const Frame<S>& frame = frames_.waiting.front();
  Taken taken = Taken::waiting;
  if (imu_.history.oldest() <= frame.time_ns()) {
    imu_.used |= 1;
    use_odometry(frame.own);
    taken = frame.own ? take_own_keyframe(frame) : track(frame);
  }
  frames_.waiting.drop_front();
  return taken;
}

template <class S>
Taken Device<S>::track(const Frame<S>& frame) {
  // while it has no camera of its own, the filter's follows the temperature
  if (has_warm_camera(theta_) && odometry_.filter.collecting()) give_filter_calibration();
  const std::int32_t late_starts = odometry_.filter.statistics().late_starts;
  const VioStatus status = odometry_.filter.push_frame(frame.time_ns(), frame.points, frame.n, imu_.history);
  // Done by this call where that is what it is to do, and so not late.
  if (!at_once_)
    d_.faults.slices_late += static_cast<std::uint32_t>(odometry_.filter.statistics().late_starts - late_starts);
  if (status == VioStatus::tracking) {
    if (builder().empty()) keep_near_origin();
    take_state(odometry_.filter.time(), odometry_.filter.state());
    if (frame.n >= kFewestTracks) frames_.at_last_use = StreamCounts(d_.faults);
    if (!d_.options.joint_filter && keyframe_due(odometry_.state_ns)) take_keyframe(frame, odometry_.state);
    return Taken::tracking;
  }
  if (status == VioStatus::lost) {
    end_segment(false);
    ++odometry_.frame;
    odometry_.has_state = false;
    return Taken::lost;
  }
  return status == VioStatus::skipped ? Taken::skipped : Taken::waiting;
}

/// A filter that has come far counts from a nearer place: a
/// whole number of metres, so that no bit of its places is lost.
template <class S>
void Device<S>::keep_near_origin() {
  const Vec3<S> p = odometry_.filter.state().p_GI;
  if (!(p.cwiseAbs().maxCoeff() > S(kFarPlace))) return;
  Vec3<S> by;
  for (int i = 0; i < 3; ++i) {
    by(i) = static_cast<S>(static_cast<std::int32_t>(p(i)));
    odometry_.origin[i] += static_cast<double>(by(i));
  }
  odometry_.filter.move_origin(by);
}

template <class S>
void Device<S>::take_state(std::int64_t t_ns, const State<S>& state) {
  ++d_.faults.frames_used;
  odometry_.state = state;
  odometry_.state_ns = t_ns;
  odometry_.has_state = true;
  odometry_.trajectory.add(t_ns);
  add_to_hash(state, &odometry_.trajectory);
}

template <class S>
template <class Point>
Taken Device<S>::push_keyframe(std::int64_t t_ns, const State<S>& state, const double* p_GI, int n, Point point) {
  if (!take_frame_stamp(t_ns)) return Taken::stamp_refused;
  if (!imu_.any || !let_wait(t_ns, 0, n, point))
    return Taken::skipped;  // without a sample nothing tells whether its stamp is one
  frames_.last_ns = t_ns;
  frames_.any = true;
  Frame<S>& frame = frames_.waiting.newest();
  frame.own = true;
  frame.state = state;
  for (int i = 0; i < 3; ++i) frame.p_GI[i] = p_GI[i];
  return process_frames();
}

template <class S>
[[gnu::cold]] Taken Device<S>::take_own_keyframe(const Frame<S>& frame) {
  State<S> x = frame.state;
  for (int i = 0; i < 3; ++i) {
    if (absolute(frame.p_GI[i] - odometry_.origin[i]) > kFarPlace) odometry_.origin[i] = frame.p_GI[i];
    x.p_GI(i) = static_cast<S>(frame.p_GI[i] - odometry_.origin[i]);
  }
  take_state(frame.time_ns(), x);
  frames_.at_last_use = StreamCounts(d_.faults);
  take_keyframe(frame, x);
  return Taken::tracking;
}

}  // namespace SEGCAL_NS
