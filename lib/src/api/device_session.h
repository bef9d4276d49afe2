// Device: where a device, a session, and an unbroken stretch of data begin and end.
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

template <class S>
void Device<S>::create(const DeviceOptions<S>& options, ColdParts<S>* cold) {
  d_.cold = cold;
  d_.options = options;
  d_.database().reset(options.keep_segments, options.metric, options.strategy, options.least_gain, options.seed);
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
  spikes_.begin(options.model.imu, options.imu_rate_hz);
  frame_period_ = 0;
  crowded_out_ = imu_spikes_ = 0;
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
  stamp_shift_ns_ = stamp_shift(theta_);
  d_.monitor.begin(options.watch_effects, prior(), theta_);
  vio_.reset(theta_, vio_options());
  restart_filter();
}

/// While nothing is pending, these are all pointers from one part to the other that are still read: a fit sets those of
/// the calibrator anew.
template <class S>
bool Device<S>::attach(ColdParts<S>* cold) {
  const auto moved = static_cast<std::ptrdiff_t>(reinterpret_cast<std::uintptr_t>(cold) -
                                                 reinterpret_cast<std::uintptr_t>(d_.cold.get()));
  if (moved == 0) return true;
  if (start_pending() || scoring() || calibrating()) return false;
  d_.cold.follow(moved);
  d_.builder.follow(moved);
  return true;
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
  if (!d_.options.joint_filter && calibrated_ && report_.release.status == Status::calibrated)
    vio_.set_calibration(theta_);
  if (!own_odometry_) ++frame_;
  for (double& o : origin_) o = 0;
  builder().begin(&open_slot(), session_, serial_, false);
  has_state_ = has_imu_ = has_frame_ = has_offered_ = has_next_keyframe_ = false;
  used_ = 0;
  has_hole_ = false;
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
  } else if (has_next_keyframe_) {  // a keyframe has come since the last time
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

/// Nothing of the stream's last session is known any more, not even how lively its motion was: the same as after a
/// restart.
template <class S>
void Device<S>::begin_session() {
  ++session_;
  ++frame_;
  knew_enough_ = false;
  liveliness_.reset();
  d_.database().begin_session();
  if (d_.options.strategy == Strategy::single_session) {
    d_.epochs.clear();
    d_.changes.close();
    condensing_ = false;
  }
  new_epoch_ = true;  // between sessions a device may change: what the new one says is held against all before
  restart_filter();
}

}  // namespace SEGCAL_NS
