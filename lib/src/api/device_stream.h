// Device: frames on their way through the filter. Faults are counted.
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

/// Images further than this from the newest IMU sample are not of its clock, ns: a FIFO or a slow driver is late by
/// less.
constexpr std::int64_t kFarFrameNs = 2000000000;
/// No camera is faster, ns: nearer stamps say nothing about its period.
constexpr std::int64_t kShortestPeriodNs = 1000000;
/// No images are missing in a longer one: it was switched off, ns.
constexpr std::int64_t kLongestPauseNs = 3600000000000;

/// Where states come from. Two sources have two frames; the user's own frame outlives gaps in the IMU's stream.
template <class S>
[[gnu::cold]] void Device<S>::use_odometry(bool own) {
  if (own == own_odometry_) return;
  if (!builder().empty()) end_segment(false);
  own_odometry_ = own;
  ++frame_;
}

/// Frames missing from an even stream. The camera's period is where the intervals lead, by a sixteenth at most each
/// time, so that a stamp that was taken late moves it little; and by a 64th where an image seems to be missing, so that
/// half of them may be.
template <class S>
[[gnu::cold]] void Device<S>::count_missing_frames(std::int64_t t_ns) {
  const std::int64_t interval = t_ns - last_frame_;
  if (interval < kShortestPeriodNs || interval > kLongestPauseNs) return;
  if (frame_period_ == 0) frame_period_ = interval;
  const std::int64_t most = frame_period_ / 16, off = interval - frame_period_;
  frame_period_ += off > frame_period_ / 2 ? most / 4 : off > most ? most : off < -most ? -most : off;
  const std::int64_t periods = (interval + frame_period_ / 2) / frame_period_;
  if (periods > 1) d_.faults.frames_dropped += static_cast<std::uint32_t>(periods - 1);
}

/// What came before the first sample, when nothing told that its stamp is far ahead: what follows must not wait for
/// that time.
template <class S>
[[gnu::cold]] void Device<S>::forget_frames() {
  frames_.clear();
  has_frame_ = has_offered_ = false;
  ++d_.faults.frame_stamps_far;
}

/// Counts a frame; false if its stamp is refused.
template <class S>
[[gnu::cold]] bool Device<S>::take_frame_stamp(std::int64_t t_ns) {
  ++d_.faults.frames;
  const bool in_range = t_ns <= kMostStamp && t_ns >= -kMostStamp;
  if (in_range && has_frame_ && last_frame_ - (has_imu_ ? last_imu_ : t_ns) > kFarFrameNs) forget_frames();
  if (!in_range || (has_imu_ && (t_ns - last_imu_ > kFarFrameNs || last_imu_ - t_ns > kFarFrameNs))) {
    ++d_.faults.frame_stamps_far;
    return false;
  }
  if (has_frame_ && t_ns <= last_frame_) {
    ++d_.faults.frame_stamps_back;
    return false;
  }
  return true;
}

/// Puts an image where it waits for its samples; false if there is no place.
template <class S>
template <class Point>
bool Device<S>::let_wait(std::int64_t t_ns, std::int32_t shift_ns, int n, Point point) {
  if (frames_.full()) {
    ++d_.faults.frames_dropped;  // the IMU's samples are too late
    ++crowded_out_;
    return false;
  }
  Frame<S>& frame = frames_.append(t_ns, shift_ns);
  const LeftOut left_out = take_points<S>(n, point, &frame);
  d_.faults.points_not_finite += left_out.not_finite;
  d_.faults.points_repeated += left_out.repeated;
  return true;
}

template <class S>
Taken Device<S>::process_frames() {
  Taken last = Taken::waiting;
  while (frame_ready()) last = process_frame();
  return frames_.empty() ? last : Taken::waiting;
}

template <class S>
template <class Point>
Taken Device<S>::push_tracks(std::int64_t t_ns, int n, Point point) {
  if (!take_frame_stamp(t_ns)) return Taken::stamp_refused;
  if (has_frame_) count_missing_frames(t_ns);
  last_frame_ = t_ns;
  has_frame_ = true;
  // Sooner than the filter wants one: no place is taken. One millisecond of grace: stamps jitter.
  if (has_offered_ && S(t_ns - last_offered_) * S(1e-9) < d_.options.frame_interval_s - S(1e-3)) return Taken::skipped;
  if (!let_wait(t_ns, stamp_shift_ns_, n, point)) return Taken::skipped;
  last_offered_ = t_ns;
  has_offered_ = true;
  if (frames_.newest().n < kFewestTracks) ++d_.faults.frames_few_tracks;
  return process_frames();
}

/// The front one.
template <class S>
Taken Device<S>::process_frame() {
  const Frame<S>& frame = frames_.front();
  Taken taken = Taken::waiting;
  if (imu_.oldest() <= frame.time_ns()) {
    used_ |= 1;
    use_odometry(frame.own);
    taken = frame.own ? take_own_keyframe(frame) : track(frame);
  }
  frames_.drop_front();
  return taken;
}

template <class S>
Taken Device<S>::track(const Frame<S>& frame) {
  const std::int32_t late_starts = vio_.statistics().late_starts;
  const VioStatus status = vio_.push_frame(frame.time_ns(), frame.points, frame.n, imu_);
  d_.faults.slices_late += static_cast<std::uint32_t>(vio_.statistics().late_starts - late_starts);
  if (status == VioStatus::tracking) {
    if (builder().empty()) keep_near_origin();
    take_state(vio_.time(), vio_.state());
    if (frame.n >= kFewestTracks) last_use_ = StreamCounts(d_.faults);
    if (!d_.options.joint_filter && keyframe_due(state_time_)) take_keyframe(frame, state_);
    return Taken::tracking;
  }
  if (status == VioStatus::lost) {
    end_segment(false);
    ++frame_;
    has_state_ = false;
    return Taken::lost;
  }
  return status == VioStatus::skipped ? Taken::skipped : Taken::waiting;
}

/// A filter that has come far counts from a nearer place: a whole number of metres, so that no bit of its places is
/// lost.
template <class S>
void Device<S>::keep_near_origin() {
  const Vec3<S> p = vio_.state().p_GI;
  if (!(p.cwiseAbs().maxCoeff() > S(kFarPlace))) return;
  Vec3<S> by;
  for (int i = 0; i < 3; ++i) {
    by(i) = static_cast<S>(static_cast<std::int32_t>(p(i)));
    origin_[i] += static_cast<double>(by(i));
  }
  vio_.move_origin(by);
}

template <class S>
void Device<S>::take_state(std::int64_t t_ns, const State<S>& state) {
  ++d_.faults.frames_used;
  state_ = state;
  state_time_ = t_ns;
  has_state_ = true;
  trajectory_.add(t_ns);
  add_to_hash(state, &trajectory_);
}

template <class S>
template <class Point>
Taken Device<S>::push_keyframe(std::int64_t t_ns, const State<S>& state, const double* p_GI, int n, Point point) {
  if (!take_frame_stamp(t_ns)) return Taken::stamp_refused;
  if (!has_imu_ || !let_wait(t_ns, 0, n, point))
    return Taken::skipped;  // without a sample nothing tells whether its stamp is one
  last_frame_ = t_ns;
  has_frame_ = true;
  Frame<S>& frame = frames_.newest();
  frame.own = true;
  frame.state = state;
  for (int i = 0; i < 3; ++i) frame.p_GI[i] = p_GI[i];
  return process_frames();
}

template <class S>
[[gnu::cold]] Taken Device<S>::take_own_keyframe(const Frame<S>& frame) {
  State<S> x = frame.state;
  for (int i = 0; i < 3; ++i) {
    if (absolute(frame.p_GI[i] - origin_[i]) > kFarPlace) origin_[i] = frame.p_GI[i];
    x.p_GI(i) = static_cast<S>(frame.p_GI[i] - origin_[i]);
  }
  take_state(frame.time_ns(), x);
  last_use_ = StreamCounts(d_.faults);
  take_keyframe(frame, x);
  return Taken::tracking;
}

}  // namespace SEGCAL_NS
