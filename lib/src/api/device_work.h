// Device: jobs in slices, and the moments at which what they found takes effect.
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

/// One slice of the work that waits; false if there is none. One job at a time: a segment's score before a calibration.
template <class S>
bool Device<S>::step() {
  if (vio_.start_pending()) {
    ++d_.slices.all;
    vio_.start_step(imu_);
  } else if (score_.active()) {
    score_.step(&d_, &scored_);
    if (!score_.active()) end_score();
  } else if (calibration_.working()) {
    calibration_.step(&d_);
  } else {
    return false;
  }
  return true;
}

template <class S>
int Device<S>::background(int slices) {
  while (slices > 0 && step()) --slices;
  return vio_.start_pending() || score_.active() || calibration_.working() ? 1 : 0;
}

/// The open segment moves to the slot that is free now. A calibration follows if the scored segment was the one that was missing.
template <class S>
void Device<S>::end_score() {
  builder().move_to(&d_.database.building());
  if (d_.options.joint_filter) return;   // segments of the caller's own odometry are scored, no more
  if (score_.condenses()) count_misfits();
  const bool enough = worth_a_calibration();
  knew_enough_ = knew_enough_ || enough;
  wanted_then_ = wanted_then_ && !undecided();
  if (wanted_then_ || (enough && d_.options.calibrates_itself)) begin_calibration(score_.theta());
}

template <class S>
void Device<S>::begin_calibration(const Calibration<S>& theta) {
  wanted_then_ = false;
  finished_ = false;
  calibration_.begin(theta, &d_);
  window_ = d_.options.calibration_window;
}

/// The kept segments tell enough for the first time; or so many were condensed since the last calibration that sigmas should
/// have halved: three times as many as it was made from.
template <class S>
bool Device<S>::worth_a_calibration() {
  if (!score_.condenses()) return score_.kept() && !knew_enough_ && knows_enough(&d_);
  if (!condensing_) return false;   // the database has just been emptied
  if constexpr (kEpochs > 0) {
    const int condensed = d_.epochs.newest().segments;
    return condensed >= 3 * (d_.epochs.segments() - condensed + d_.database.size());
  }
  return false;
}

template <class S>
void Device<S>::finish_score() {
  while (score_.active()) step();
}

/// Does what is left of the calibration under way (nobody scores while there is one), and lets it take effect. The open segment
/// must be empty, or end here: a segment has one shift of stamps for all of its keyframes.
template <class S>
void Device<S>::publish_calibration() {
  window_ = 0;
  while (calibration_.working()) step();
  const bool dropped = calibration_.publish(&d_, &report_);
  if constexpr (kEpochs > 0) {
    if (report_.release.status == Status::calibrated) d_.changes.decide(theta_, report_.release.theta, report_.release.sigma);
  }
  ++d_.faults.calibrations_published;
  calibrated_ = true;
  if (dropped) knew_enough_ = knew_enough_ && knows_enough(&d_);
  take_release();
  set_condensing();
}

/// From a released theta on, as long as the database holds what it was made from: another segment in it would push one out that
/// nothing else remembers. Where theta cannot be released, epochs are no help to find out why.
template <class S>
void Device<S>::set_condensing() {
  if (report_.release.status == Status::failed) forget_epochs();
  condensing_ = kEpochs > 0 && d_.options.condense && report_.release.status == Status::calibrated && knows_enough(&d_);
  new_epoch_ = true;
  misfits_ = 0;
  d_.condenser.break_chain();
}

template <class S>
void Device<S>::forget_epochs() {
  if constexpr (kEpochs > 0) d_.faults.segments_outdated += static_cast<std::uint32_t>(d_.epochs.segments());
  d_.epochs.clear();
  d_.changes.close();
}

/// Where a segment contradicts what is known, or one after the other fits no longer, theta may be another than epochs were made at.
template <class S>
void Device<S>::count_misfits() {
  if (!score_.judged()) return;
  if constexpr (kEpochs > 0) misfits_ = d_.condenser.condensed() ? 0 : misfits_ + 1;
  if (!score_.contradicts() && misfits_ < kMostMisfits) return;
  suspect_change();
  collect_anew();
}

/// Between the newest segment of what the contradiction is with, and this one. Of segments that did not fit that is the third.
template <class S>
void Device<S>::suspect_change() {
  if constexpr (kEpochs > 0) {
    std::uint32_t before = 0;
    for (int i = 0; i < Database<S>::kSlots; ++i) {
      if (d_.database.kept(i) && d_.database.slot(i).session > before) before = d_.database.slot(i).session;
    }
    const int known = d_.epochs.count() - (score_.contradicts() && score_.contradicts_since_epoch() ? 1 : 0);
    for (int i = 0; i < known; ++i) {
      const Epoch<S>& e = d_.epochs.epoch(i);
      if (e.segments > 0 && e.last_session > before) before = e.last_session;
    }
    d_.changes.open(before, scored_.segment.session, scored_.segment.start_ns, report_.release.sigma, theta_.columns());
  }
}

/// What came since contradicts what was known, and is not enough to tell which is right: what was released stays.
template <class S>
bool Device<S>::undecided() {
  return d_.changes.open() && !knows_enough(&d_);
}

/// What the kept segments say becomes an epoch, and the database is free for segments that can be linearised again: the next
/// calibration compares them with all epochs, and drops what they contradict (agreement.h).
template <class S>
void Device<S>::collect_anew() {
  misfits_ = 0;
  condensing_ = knew_enough_ = false;
  d_.condenser.break_chain();
  if constexpr (kEpochs > 0) {
    Segment<S>* segments[kMaxSegments];
    const int n = d_.database.in_order(segments);
    if (n == 0) return;
    Epoch<S>& epoch = d_.epochs.insert(report_.theta, segments[0]->session, segments[n - 1]->serial);
    for (int i = 0; i < n; ++i) {
      epoch.add(segments[i]->information.triangle(), S(segments[i]->information.dof), {}, segments[i]->session, segments[i]->serial);
      d_.database.drop(static_cast<int>(segments[i] - &d_.database.slot(0)));
    }
  }
}

/// The same at any moment: where the shift of stamps changes, the open segment begins anew.
template <class S>
void Device<S>::finish_calibration() {
  if (!calibration_.pending()) return;
  const std::int32_t shift = stamp_shift_ns_;
  publish_calibration();
  if (stamp_shift_ns_ == shift || builder().empty()) return;
  begin_segment(false);
}

template <class S>
void Device<S>::take_release() {
  if (report_.release.status != Status::calibrated) return;
  theta_ = report_.release.theta;
  d_.monitor.reset(prior(), theta_);
  stamp_shift_ns_ = stamp_shift(theta_);
  if (vio_.initialised()) vio_.set_calibration(theta_);
}

template <class S>
void Device<S>::calibrate() {
  finish_score();
  finish_calibration();
  calibrate_as_wanted();
  finish_calibration();
  finished_ = true;
}

/// Nothing else is pending. Of the filter's own calibration: at once, that is short.
template <class S>
void Device<S>::calibrate_as_wanted() {
  wanted_ = false;
  if (d_.options.joint_filter) {
    ++d_.faults.calibrations;
    ++d_.faults.calibrations_published;
    InformationAnalysis<S>* analysis = d_.work.new_analysis();
    read_filter(&report_.release, analysis);
    report_.directions.copy(*analysis);
    calibrated_ = true;
    theta_ = report_.theta = report_.release.theta;
  } else if (!undecided()) {
    begin_calibration(working_theta());
  }
}

template <class S>
void Device<S>::read_filter(Release<S>* out, InformationAnalysis<S>* analysis) {
  vio_.finish_start(imu_);  // it works in the filter's memory
  if (!vio_.knows_sensors()) return release_prior(prior(), out);
  const Calibration<S>& theta = vio_.calibration();
  PackedTriangle<S> R(vio_.scratch(), theta.columns() + 1);
  vio_.calibration_information(&R);
  for (int i = theta.effect_column(); i < theta.columns(); ++i) R.row(i)[i] = S(1) / prior().sigma[i];
  if (analysis) analyse_with_prior(R, prior().sigma, analysis);
  judge_filter(theta, prior(), ReleaseRules<S>{}, &R, out);
}

template <class S>
S Device<S>::linearise(const std::uint8_t* use_slot, const CandidateTerms& candidates) {
  Segment<S>* segments[kMaxSegments];
  bool use[kMaxSegments];
  const int count = d_.database.in_order(segments);
  const bool known = calibrated_ && report_.release.status != Status::failed && !d_.options.joint_filter;
  d_.work.eliminator().restart();
  d_.calibrator.continue_with(segments, count, prior(), known ? d_.calibrator.theta() : working_theta(), d_.options.model);
  for (int i = 0; i < count; ++i) use[i] = use_slot[segments[i] - &d_.database.slot(0)] != 0;
  return d_.calibrator.rows_of(use, candidates, &d_.work.eliminator());
}

template <class S>
std::uint64_t Device<S>::result_hash() const {
  Hash hash = trajectory_;
  add_to_hash(theta_, &hash);
  if (calibrated_) add_to_hash(report_.release, &hash);
  if (finished_) add_to_hash(d_.database, &hash);
  if (finished_) add_to_hash(d_.epochs, &hash);
  return hash.value();
}

}  // namespace SEGCAL_NS
