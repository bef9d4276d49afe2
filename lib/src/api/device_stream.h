// Device: samples and frames on their way through the filter. Faults are counted, gaps begin anew.
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

/// Images further than this from the newest IMU sample are not of its clock, ns: a FIFO or a slow driver is late by less.
constexpr std::int64_t kFarFrameNs = 2000000000;
/// No camera is faster, ns: nearer stamps say nothing about its period.
constexpr std::int64_t kShortestPeriodNs = 1000000;

template <class S>
void Device<S>::create(const DeviceOptions<S>& options) {
  d_.options = options;
  d_.database.reset(options.keep_segments, options.metric, options.strategy, options.least_gain, options.seed);
  d_.builder.reset(options.gyro_range, options.accel_range);
  d_.faults = FaultCounts{};
  d_.slices = SliceCounts{};
  d_.work.give_back();
  theta_ = options.prior.mean;
  report_.release = Release<S>{};
  report_.directions.n = scored_.directions.n = 0;
  scored_.segment = SegmentSummary<S>{};
  score_.reset();
  calibration_.reset();
  decimation_.begin(options.imu_group);
  frame_period_ = 0;
  crowded_out_ = 0;
  session_ = serial_ = frame_ = 0;
  trajectory_ = Hash{};
  window_ = thinned_ = 0;
  liveliness_.reset();
  last_use_ = StreamCounts();
  calibrated_ = knew_enough_ = own_odometry_ = condensing_ = at_once_ = wanted_ = wanted_then_ = false;
  new_epoch_ = true;
  misfits_ = made_from_ = open_segments_ = 0;
  d_.epochs.clear();
  d_.changes.clear();
  d_.condenser.break_chain();
  finished_ = true;
  spare_ = nullptr;
  stamp_shift_ns_ = stamp_shift(theta_);
  d_.monitor.begin(options.watch_effects, prior(), theta_);
  vio_.reset(theta_, vio_options());
  restart_filter();
}

/// The filter states its own calibration only where that is asked for; then it starts from the device's prior.
template <class S>
VioOptions<S> Device<S>::vio_options() const {
  const DeviceOptions<S>& o = d_.options;
  VioOptions<S> vio;
  vio.noise = o.model.imu;
  vio.g = o.model.g;
  vio.frame_interval_s = o.frame_interval_s;
  vio.late_start_at_once = at_once_;
  vio.share_calibration(o.filter_share);
  if (!o.joint_filter) return vio;
  const S* sigma = prior().sigma;
  const S* imu_sigma = sigma + prior().mean.imu_column();
  vio.pixel_sigma = o.model.pixel_sigma;
  vio.sigma_r_CI = sigma[0];
  vio.sigma_p_CI = sigma[3];
  vio.sigma_focal = sigma[6] / prior().mean.camera[0].intrinsics(0);
  vio.sigma_centre = sigma[8];
  vio.sigma_distortion = sigma[10];
  vio.sigma_gyro = imu_sigma[0];
  vio.sigma_accel = imu_sigma[6];
  vio.sigma_r_AI = imu_sigma[12];
  return vio;
}

/// Everything that belongs to one unbroken stretch of data starts anew.
template <class S>
void Device<S>::restart_filter() {
  imu_.clear();
  imu_clock_.reset();
  decimation_.clear();
  frames_.clear();
  if (d_.options.joint_filter && vio_.knows_sensors()) {
    vio_.next_session();
  } else {
    vio_.reset(theta_, vio_options());
  }
  if (!d_.options.joint_filter && calibrated_ && report_.release.status == Status::calibrated) vio_.set_calibration(theta_);
  if (!own_odometry_) ++frame_;
  for (double& o : origin_) o = 0;
  builder().begin(&open_slot(), session_, serial_, false);
  has_state_ = has_imu_ = has_frame_ = has_offered_ = has_next_keyframe_ = false;
}

/// Where states come from. Two sources have two frames; the user's own frame outlives gaps in the IMU's stream.
template <class S>
void Device<S>::use_odometry(bool own) {
  if (own == own_odometry_) return;
  if (!builder().empty()) end_segment(false);
  own_odometry_ = own;
  ++frame_;
}

template <class S>
Taken Device<S>::push_imu(std::int64_t t_ns, const InertialReading<S>& reading, S celsius) {
  ++d_.faults.imu_samples;
  if (!is_finite(reading.gyro.sum()) || !is_finite(reading.accel.sum())) {
    ++d_.faults.imu_not_finite;
    return Taken::not_finite;
  }
  const bool began = has_imu_;
  switch (imu_clock_.take(t_ns)) {
    case StampVerdict::good: break;
    case StampVerdict::back: ++d_.faults.imu_stamps_back; return Taken::stamp_refused;
    case StampVerdict::far: ++d_.faults.imu_stamps_far; return Taken::stamp_refused;
    case StampVerdict::anew:
      if (began && t_ns > last_imu_) break;   // a long gap
      ++d_.faults.clock_restarts;
      end_segment(false);
      restart_filter();
      imu_clock_.take(t_ns);
      break;
  }
  if (!began && d_.faults.imu_samples - d_.faults.imu_not_finite - d_.faults.imu_stamps_far == 1) start_clock(t_ns);
  if (d_.options.has_temperature && is_finite(celsius)) imu_.set_warmth(celsius - S(25));
  for (int i = 0; i < 3; ++i) {
    if (absolute(reading.gyro(i)) < d_.options.gyro_range && absolute(reading.accel(i)) < d_.options.accel_range) continue;
    ++d_.faults.imu_saturated;
    return Taken::skipped;   // what it measured is not known; its neighbours bridge it, or it is a gap
  }
  if (has_imu_ && S(t_ns - last_imu_) * S(1e-9) > S(3) / d_.options.imu_rate_hz) {
    ++d_.faults.imu_gaps;
    break_stream();
    imu_clock_.take(t_ns);
  }
  last_imu_ = t_ns;
  has_imu_ = true;
  InertialReading<S> mean = reading;
  if (decimation_.take(&t_ns, &mean)) imu_.push(t_ns, mean);
  return frame_ready() ? process_frame() : Taken::ok;
}

/// Signal::time counts from the first sample.
template <class S>
void Device<S>::start_clock(std::int64_t t_ns) {
  d_.options.prior.mean.effects.time_zero_ns = theta_.effects.time_zero_ns = t_ns;
  vio_.set_time_zero(t_ns);
}

/// A gap: the open segment ends with what it has, the filter starts again.
template <class S>
void Device<S>::break_stream() {
  const std::int64_t last_frame = last_frame_;
  const bool has_frame = has_frame_;
  end_segment(false);
  restart_filter();
  last_frame_ = last_frame;
  has_frame_ = has_frame;
}

/// Frames missing from an even stream: the shortest interval seen so far is the camera's period.
template <class S>
void Device<S>::count_missing_frames(std::int64_t t_ns) {
  const std::int64_t interval = t_ns - last_frame_;
  if (interval < kShortestPeriodNs) return;
  if (frame_period_ == 0 || interval < frame_period_) frame_period_ = interval;
  const std::int64_t periods = (interval + frame_period_ / 2) / frame_period_;
  if (periods > 1) d_.faults.frames_dropped += static_cast<std::uint32_t>(periods - 1);
}

/// Counts a frame; false if its stamp is refused.
template <class S>
bool Device<S>::take_frame_stamp(std::int64_t t_ns) {
  ++d_.faults.frames;
  const bool in_range = t_ns <= kMostStamp && t_ns >= -kMostStamp;
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

template <class S>
template <class Point>
Taken Device<S>::push_tracks(std::int64_t t_ns, int n, Point point) {
  if (!take_frame_stamp(t_ns)) return Taken::stamp_refused;
  if (has_frame_) count_missing_frames(t_ns);
  last_frame_ = t_ns;
  has_frame_ = true;
  // Sooner than the filter wants one: no place is taken. One millisecond of grace: stamps jitter.
  if (has_offered_ && S(t_ns - last_offered_) * S(1e-9) < d_.options.frame_interval_s - S(1e-3)) return Taken::skipped;
  if (frames_.full()) {
    ++d_.faults.frames_dropped;  // the IMU's samples are too late
    ++crowded_out_;
    return Taken::skipped;
  }
  last_offered_ = t_ns;
  has_offered_ = true;
  Frame<S>& frame = frames_.append(t_ns, stamp_shift_ns_);
  const LeftOut left_out = take_points<S>(n, point, &frame);
  d_.faults.points_not_finite += left_out.not_finite;
  d_.faults.points_repeated += left_out.repeated;
  if (frame.n < kFewestTracks) ++d_.faults.frames_few_tracks;
  Taken last = Taken::waiting;
  while (frame_ready()) last = process_frame();
  return frames_.empty() ? last : Taken::waiting;
}

template <class S>
Taken Device<S>::process_frame() {
  const Frame<S>& frame = frames_.front();
  const std::int64_t t_ns = frame.time_ns();
  if (imu_.oldest() > t_ns) {
    frames_.drop_front();
    return Taken::waiting;
  }
  use_odometry(false);
  const std::int32_t late_starts = vio_.statistics().late_starts;
  const VioStatus status = vio_.push_frame(t_ns, frame.points, frame.n, imu_);
  d_.faults.slices_late += static_cast<std::uint32_t>(vio_.statistics().late_starts - late_starts);
  Taken taken = Taken::waiting;
  if (status == VioStatus::tracking) {
    if (builder().empty()) keep_near_origin();
    take_state(vio_.time(), vio_.state());
    if (frame.n >= kFewestTracks) last_use_ = StreamCounts(d_.faults);
    if (!d_.options.joint_filter && keyframe_due(state_time_)) take_keyframe(frame, state_);
    taken = Taken::tracking;
  } else if (status == VioStatus::lost) {
    end_segment(false);
    ++frame_;
    has_state_ = false;
    taken = Taken::lost;
  } else if (status == VioStatus::skipped) {
    taken = Taken::skipped;
  }
  frames_.drop_front();
  return taken;
}

/// A filter that has come far counts from a nearer place: a whole number of metres, so that no bit of its places is lost.
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
  if (!imu_.covers(t_ns, t_ns)) return Taken::waiting;
  last_frame_ = t_ns;
  has_frame_ = true;
  use_odometry(true);
  frames_.clear();
  Frame<S>& frame = frames_.append(t_ns, 0);
  const LeftOut left_out = take_points<S>(n, point, &frame);
  d_.faults.points_not_finite += left_out.not_finite;
  d_.faults.points_repeated += left_out.repeated;
  State<S> x = state;
  for (int i = 0; i < 3; ++i) {
    if (absolute(p_GI[i] - origin_[i]) > kFarPlace) origin_[i] = p_GI[i];
    x.p_GI(i) = static_cast<S>(p_GI[i] - origin_[i]);
  }
  take_state(t_ns, x);
  last_use_ = StreamCounts(d_.faults);
  take_keyframe(frame, x);
  frames_.clear();
  return Taken::tracking;
}

template <class S>
void Device<S>::flush() {
  while (flush_step()) {
  }
}

/// Pending work first: nothing that comes then finds it undone.
template <class S>
bool Device<S>::flush_step() {
  if (step()) return true;
  if (frame_ready()) {
    process_frame();
  } else if (calibration_.pending()) {
    finish_calibration();
  } else if (has_next_keyframe_) {   // a keyframe has come since the last time
    end_segment(false);
    has_next_keyframe_ = false;
  } else if (wanted_) {
    calibrate_as_wanted();
  } else {
    finished_ = true;
    return false;
  }
  return true;
}

template <class S>
void Device<S>::new_session() {
  flush();
  begin_session();
}

/// Nothing of the stream's last session is known any more, not even how lively its motion was: the same as after a restart.
template <class S>
void Device<S>::begin_session() {
  ++session_;
  ++frame_;
  knew_enough_ = false;
  liveliness_.reset();
  d_.database.begin_session();
  if (d_.options.strategy == Strategy::single_session) {
    d_.epochs.clear();
    d_.changes.close();
    condensing_ = false;
  }
  new_epoch_ = true;   // between sessions a device may change: what the new one says is held against all before
  restart_filter();
}

}  // namespace SEGCAL_NS
