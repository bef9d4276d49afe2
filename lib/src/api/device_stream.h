// Device: samples and frames on their way through the filter. Faults are counted, gaps begin anew.
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

template <class S>
void Device<S>::create(const DeviceOptions<S>& options) {
  options_ = options;
  theta_ = options.prior.mean;
  database_.reset(options.keep_segments, options.metric, options.strategy, options.least_gain, options.seed);
  builder_.reset(options.gyro_range, options.accel_range);
  faults_ = FaultCounts{};
  release_ = Release<S>{};
  joint_.n = analysis_.n = 0;
  joint_.W = analysis_.W = eliminator_.lend();
  frame_period_ = 0;
  session_ = serial_ = frame_ = 0;
  trajectory_ = Hash{};
  thinned_ = 0;
  liveliness_.reset();
  last_ = SegmentSummary<S>{};
  calibrated_ = knew_enough_ = own_odometry_ = false;
  scoring_ = calibrating_ = dropped_ = settled_ = false;
  window_ = n_taking_part_ = i_ = round_ = 0;
  score_place_ = calibrate_place_ = inner_place_ = 0;
  spare_ = nullptr;
  stamp_shift_ns_ = stamp_shift(theta_);
  monitor_.begin(options.watch_effects, prior(), theta_);
  vio_.reset(theta_, vio_options());
  restart_filter();
}

/// The filter states its own calibration only where that is asked for; then it starts from the device's prior.
template <class S>
VioOptions<S> Device<S>::vio_options() const {
  VioOptions<S> vio;
  vio.noise = options_.model.imu;
  vio.g = options_.model.g;
  vio.frame_interval_s = options_.frame_interval_s;
  vio.share_calibration(options_.filter_share);
  if (!options_.joint_filter) return vio;
  const S* sigma = prior().sigma;
  const S* imu_sigma = sigma + prior().mean.imu_column();
  vio.pixel_sigma = options_.model.pixel_sigma;
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
  if (options_.joint_filter && vio_.knows_sensors()) {
    vio_.next_session();
  } else {
    vio_.reset(theta_, vio_options());
  }
  if (!options_.joint_filter && calibrated_ && release_.status != Status::failed) vio_.set_calibration(theta_);
  if (!own_odometry_) ++frame_;
  builder_.begin(&open_slot(), session_, serial_, false);
  state_time_ = last_imu_ = last_frame_ = pending_time_ = next_keyframe_ = kNever;
  pending_count_ = 0;
}

/// Where states come from. Two sources have two frames; the user's own frame outlives gaps in the IMU's stream.
template <class S>
void Device<S>::use_odometry(bool own) {
  if (own == own_odometry_) return;
  if (!builder_.empty()) end_segment(false);
  own_odometry_ = own;
  ++frame_;
}

template <class S>
Taken Device<S>::push_imu(std::int64_t t_ns, const InertialReading<S>& reading) {
  ++faults_.imu_samples;
  if (!is_finite(reading.gyro.sum()) || !is_finite(reading.accel.sum())) {
    ++faults_.imu_not_finite;
    return Taken::not_finite;
  }
  if (last_imu_ != kNever && t_ns <= last_imu_) {
    ++faults_.imu_stamps_back;
    return Taken::stamp_back;
  }
  for (int i = 0; i < 3; ++i) {
    if (absolute(reading.gyro(i)) < options_.gyro_range && absolute(reading.accel(i)) < options_.accel_range) continue;
    ++faults_.imu_saturated;
    break;
  }
  if (faults_.imu_samples == 1) start_clock(t_ns);
  if (last_imu_ != kNever && S(t_ns - last_imu_) * S(1e-9) > S(3) / options_.imu_rate_hz) {
    ++faults_.imu_gaps;
    break_stream();
  }
  last_imu_ = t_ns;
  imu_.push(t_ns, reading);
  return pending_count_ > 0 && imu_.newest() >= pending_time_ ? process_frame() : Taken::ok;
}

/// Signal::time counts from the first sample.
template <class S>
void Device<S>::start_clock(std::int64_t t_ns) {
  options_.prior.mean.effects.time_zero_ns = theta_.effects.time_zero_ns = t_ns;
  vio_.set_time_zero(t_ns);
}

/// A gap: the open segment ends with what it has, the filter starts again.
template <class S>
void Device<S>::break_stream() {
  const std::int64_t last_frame = last_frame_;
  end_segment(false);
  restart_filter();
  last_frame_ = last_frame;
}

/// Frames missing from an even stream: the shortest interval seen so far is the camera's period.
template <class S>
void Device<S>::count_missing_frames(std::int64_t t_ns) {
  if (last_frame_ == kNever) return;
  const std::int64_t interval = t_ns - last_frame_;
  if (frame_period_ == 0 || interval < frame_period_) frame_period_ = interval;
  const std::int64_t periods = (interval + frame_period_ / 2) / frame_period_;
  if (periods > 1) faults_.frames_dropped += static_cast<std::uint32_t>(periods - 1);
}

template <class S>
Taken Device<S>::push_tracks(std::int64_t t_ns, const TrackPoint<S>* points, int n) {
  ++faults_.frames;
  if (last_frame_ != kNever && t_ns <= last_frame_) {
    ++faults_.frame_stamps_back;
    return Taken::stamp_back;
  }
  if (pending_count_ > 0) ++faults_.frames_dropped;  // its IMU samples never came
  count_missing_frames(t_ns);
  last_frame_ = t_ns;
  pending_time_ = t_ns + stamp_shift_ns_;
  pending_count_ = 0;
  for (int i = 0; i < n && pending_count_ < kMaxFramePoints; ++i) {
    if (is_finite(points[i].uv.x()) && is_finite(points[i].uv.y())) {
      pending_[pending_count_++] = points[i];
    } else {
      ++faults_.points_not_finite;
    }
  }
  if (pending_count_ < kFewestTracks) ++faults_.frames_few_tracks;
  if (imu_.size() < 2 || imu_.newest() < pending_time_) return Taken::waiting;
  return process_frame();
}

template <class S>
Taken Device<S>::process_frame() {
  const int n = pending_count_;
  pending_count_ = 0;
  if (imu_.oldest() > pending_time_) return Taken::waiting;
  use_odometry(false);
  const std::int32_t late_starts = vio_.statistics().late_starts;
  const VioStatus status = vio_.push_frame(pending_time_, pending_, n, imu_);
  faults_.slices_late += static_cast<std::uint32_t>(vio_.statistics().late_starts - late_starts);
  switch (status) {
    case VioStatus::skipped: return Taken::skipped;
    case VioStatus::lost:
      end_segment(false);
      ++frame_;
      state_time_ = kNever;
      return Taken::lost;
    case VioStatus::tracking: break;
    default: return Taken::waiting;
  }
  take_state(vio_.time(), vio_.state());
  if (!options_.joint_filter && keyframe_due(state_time_)) take_keyframe(state_time_, state_, pending_, n);
  return Taken::tracking;
}

template <class S>
void Device<S>::take_state(std::int64_t t_ns, const State<S>& state) {
  ++faults_.frames_used;
  state_ = state;
  state_time_ = t_ns;
  trajectory_.add(t_ns);
  add_to_hash(state, &trajectory_);
}

template <class S>
Taken Device<S>::push_keyframe(std::int64_t t_ns, const State<S>& state, const TrackPoint<S>* points, int n) {
  ++faults_.frames;
  if (last_frame_ != kNever && t_ns <= last_frame_) {
    ++faults_.frame_stamps_back;
    return Taken::stamp_back;
  }
  if (!imu_.covers(t_ns, t_ns)) return Taken::waiting;
  last_frame_ = t_ns;
  use_odometry(true);
  take_state(t_ns, state);
  take_keyframe(t_ns, state, points, n);
  return Taken::tracking;
}

template <class S>
std::uint64_t Device<S>::result_hash() const {
  Hash hash = trajectory_;
  add_to_hash(theta_, &hash);
  if (calibrated_) add_to_hash(release_, &hash);
  add_to_hash(database_, &hash);
  return hash.value();
}

template <class S>
void Device<S>::flush() {
  if (pending_count_ > 0 && imu_.covers(pending_time_, pending_time_)) process_frame();
  finish_score();
  if (window_ > 0) finish_calibration();
  end_segment(false);
  finish_score();
  if (window_ > 0) finish_calibration();
  next_keyframe_ = kNever;
}

template <class S>
void Device<S>::new_session() {
  flush();
  ++session_;
  ++frame_;
  knew_enough_ = false;
  database_.begin_session();
  restart_filter();
}

}  // namespace SEGCAL_NS
