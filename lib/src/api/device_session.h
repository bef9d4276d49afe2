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
  d_.work.reset();
  d_.epochs.clear();
  d_.changes.clear();
  d_.history.clear();
  d_.condenser.break_chain();
  theta_ = options.prior.mean;
  stamp_shift_ns_ = stamp_shift(theta_);
  d_.monitor.begin(options.watch_effects, prior(), theta_);
  jobs_.reset();
  imu_.create(options.model, options.imu_rate_hz, options.imu_group);
  frames_.create();
  odometry_.create();
  grid_.create();
  session_ = serial_ = 0;
  at_once_ = false;
  odometry_.filter.reset(theta_, vio_options());
  restart_filter();
}

/// While nothing is pending, these are all pointers from one part to the
/// other that are still read: a fit sets those of the calibrator anew.
template <class S>
bool Device<S>::attach(ColdParts<S>* cold) {
  const auto moved = static_cast<std::ptrdiff_t>(reinterpret_cast<std::uintptr_t>(cold) -
                                                 reinterpret_cast<std::uintptr_t>(d_.cold.get()));
  if (moved == 0) return true;
  if (start_pending() || jobs_.working()) return false;
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
  vio.track_walk = o.model.track_walk;
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
  Vio<S>& filter = odometry_.filter;
  imu_.clear();
  frames_.clear();
  if (d_.options.joint_filter && filter.knows_sensors()) {
    filter.next_session();
  } else {
    filter.restart(theta_, vio_options());
  }
  if (!d_.options.joint_filter && jobs_.released()) give_filter_calibration();
  if (!odometry_.own) ++odometry_.frame;
  odometry_.clear();
  grid_.clear();
  builder().begin(&open_slot(), session_, serial_, false);
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
  } else if (jobs_.calibration_pending()) {
    finish_calibration();
  } else if (grid_.any) {  // a keyframe has come since the last time
    end_segment(false);
    grid_.any = false;
  } else if (jobs_.requested()) {
    calibrate_as_wanted();
  } else {
    jobs_.set_finished();
    return false;
  }
  return true;
}

template <class S>
void Device<S>::new_session() {
  flush();
  begin_session();
}

/// Nothing of the stream's last session is known any more, not
/// even how lively its motion was: the same as after a restart.
template <class S>
void Device<S>::begin_session() {
  ++session_;
  ++odometry_.frame;
  grid_.liveliness.reset();
  d_.database().begin_session();
  jobs_.begin_session(&d_);
  restart_filter();
}

}  // namespace SEGCAL_NS
