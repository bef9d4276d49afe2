// Device: background work, and what takes effect when it is done.
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

/// One slice of the work that waits; false if there is none: the filter's start first, which runs in its own memory,
/// then a segment's score, then a calibration.
template <class S>
bool Device<S>::step() {
  if (!odometry_.filter.start_pending()) return jobs_.step(&d_);
  ++d_.slices.all;
  odometry_.filter.start_step(imu_.history);
  return true;
}

/// Where a job is about to be finished in one go: a start that is pending has its slices before it.
template <class S>
void Device<S>::finish_start() {
  while (jobs_.working() && odometry_.filter.start_pending()) step();
}

template <class S>
int Device<S>::background(int slices) {
  while (slices > 0 && step()) --slices;
  return odometry_.filter.start_pending() || jobs_.working() ? 1 : 0;
}

/// The calibration under way takes effect. The open segment must be empty, or end here: a segment has one shift of
/// stamps for all of its keyframes.
template <class S>
void Device<S>::publish_calibration() {
  finish_start();
  jobs_.publish(theta_, &d_);
  take_release();
}

/// The same at any moment: where the shift of stamps changes, the open segment begins anew.
template <class S>
void Device<S>::finish_calibration() {
  if (!jobs_.calibration_pending()) return;
  const std::int32_t shift = stamp_shift_ns_;
  publish_calibration();
  if (stamp_shift_ns_ == shift || builder().empty()) return;
  begin_segment(false);
}

template <class S>
void Device<S>::take_release() {
  if (!jobs_.released()) return;
  theta_ = jobs_.report().release.theta;
  d_.monitor.reset(prior(), theta_);
  stamp_shift_ns_ = stamp_shift(theta_);
  if (odometry_.filter.initialised()) give_filter_calibration();
}

template <class S>
void Device<S>::give_filter_calibration() {
  if (!has_warm_camera(theta_)) return odometry_.filter.set_calibration(theta_);
  Calibration<S> now = theta_;
  move_cameras(imu_.history.warmth(), &now);
  odometry_.filter.set_calibration(now);
}

template <class S>
void Device<S>::calibrate() {
  finish_start();
  jobs_.finish_score(&d_);
  finish_calibration();
  calibrate_as_wanted();
  finish_calibration();
  jobs_.set_finished();
}

/// Nothing else is pending. Of the filter's own calibration: at once, that is short.
template <class S>
void Device<S>::calibrate_as_wanted() {
  if (!d_.options.joint_filter) return jobs_.begin_requested(working_theta(), &d_);
  ++d_.faults.calibrations;
  ++d_.faults.calibrations_published;
  CalibrationReport<S>* report = jobs_.publish_without_job();
  typename Workspace<S>::Lease work;
  d_.work.begin_lease(WorkOwner::question, &work);
  InformationAnalysis<S>* analysis = work.new_analysis();
  read_filter(&report->release, analysis);
  report->directions.copy(*analysis);
  work.end();
  theta_ = report->theta = report->release.theta;
}

template <class S>
[[gnu::cold]] void Device<S>::read_filter(Release<S>* out, InformationAnalysis<S>* analysis) {
  Vio<S>& filter = odometry_.filter;
  filter.finish_start(imu_.history);  // it works in the filter's memory
  if (!filter.knows_sensors()) return release_prior(prior(), out);
  const Calibration<S>& theta = filter.calibration();
  PackedTriangle<S> R = filter.calibration_information();
  for (int i = theta.effect_column(); i < theta.columns(); ++i) R.row(i)[i] = S(1) / prior().sigma[i];
  if (analysis) analyse_with_prior(R, prior().sigma, analysis);
  judge_filter(theta, prior(), ReleaseRules<S>{}, &R, out);
}

template <class S>
S Device<S>::linearise(const std::uint8_t* use_slot, const CandidateTerms& candidates) {
  Near<Segment<S>> segments[kMaxSegments];
  bool use[kMaxSegments];
  const int count = d_.database().in_order(segments);
  const bool known = has_report() && report().release.status != Status::failed && !d_.options.joint_filter;
  d_.calibrator().continue_with(segments, count, prior(), known ? report().theta : working_theta(), d_.options.model);
  for (int i = 0; i < count; ++i) use[i] = use_slot[segments[i] - &d_.database().slot(0)] != 0;
  typename Workspace<S>::Lease work;
  d_.work.begin_lease(WorkOwner::question, &work);
  const S dof = d_.calibrator().rows_of(use, candidates, &work.eliminator());
  work.end();
  return dof;
}

template <class S>
std::uint64_t Device<S>::result_hash() const {
  Hash hash = odometry_.trajectory;
  add_to_hash(theta_, &hash);
  if (has_report()) add_to_hash(report().release, &hash);
  if (jobs_.finished()) add_to_hash(d_.database(), &hash);
  if (jobs_.finished()) add_to_hash(d_.epochs, &hash);
  return hash.value();
}

}  // namespace SEGCAL_NS
