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

/// The open segment moves to the slot that is free now. A calibration follows if the scored segment was the one that
/// was missing.
template <class S>
void Device<S>::end_score() {
  builder().move_to(&d_.database().building());
  if (d_.options.joint_filter) return;  // segments of the caller's own odometry are scored, no more
  if (score_.condenses()) count_misfits();
  open_segments_ = d_.changes.open() ? open_segments_ + 1 : 0;
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

/// The kept segments tell enough for the first time; or so many were condensed since the last calibration that sigmas
/// should have halved: three times as many as it was made from.
template <class S>
bool Device<S>::worth_a_calibration() {
  if (waited_enough()) return true;
  if (score_.emptied()) return false;
  if (!score_.condenses()) return score_.kept() && !knew_enough_ && knows_enough(&d_);
  if constexpr (kEpochs > 0) return d_.epochs.segments() + d_.database().size() >= 4 * made_from_;
  return false;
}

template <class S>
void Device<S>::finish_score() {
  while (score_.active()) step();
}

/// Does what is left of the calibration under way (nobody scores while there is one), and lets it take effect. The open
/// segment must be empty, or end here: a segment has one shift of stamps for all of its keyframes.
template <class S>
void Device<S>::publish_calibration() {
  window_ = 0;
  while (calibration_.working()) step();
  const bool dropped = calibration_.publish(&d_, &report_);
  if constexpr (kEpochs > 0) {
    made_from_ = d_.epochs.segments() + d_.database().size();
    if (calibration_.changed() && report_.release.status == Status::calibrated) {
      d_.changes.decide(theta_, report_.release.theta, report_.release.sigma);
    }
    d_.changes.close();  // no change: a false alarm; not calibrated: that is what the result says now
  }
  ++d_.faults.calibrations_published;
  calibrated_ = true;
  if (dropped) knew_enough_ = knew_enough_ && knows_enough(&d_);
  take_release();
  set_condensing();
}

/// From a released theta on, as long as the database holds what it was made from: another segment in it would push one
/// out that nothing else remembers. Where theta cannot be released, epochs are no help to find out why.
template <class S>
void Device<S>::set_condensing() {
  if (report_.release.status == Status::failed) forget_epochs();
  condensing_ = kEpochs > 0 && d_.options.condense && report_.release.status == Status::calibrated &&
                (d_.epochs.count() > 0 || knows_enough(&d_));
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

/// Where a segment contradicts what is known, or one after the other fits no longer, theta may be another than epochs
/// were made at: the database collects anew.
template <class S>
void Device<S>::count_misfits() {
  if constexpr (kEpochs > 0) {
    if (!score_.judged()) return;
    misfits_ = d_.condenser.condensed() ? 0 : misfits_ + 1;
    if (!score_.emptied()) return;
    misfits_ = 0;
    condensing_ = knew_enough_ = false;
    d_.changes.open(score_.session_before(), scored_.segment.session, scored_.segment.start_ns, report_.release.sigma,
                    theta_.columns());
  }
}

/// What came since contradicts what was known, and is not enough to tell which is right: what was released stays,
/// however long that takes. A calibration that could not convict what is older would confirm it.
template <class S>
bool Device<S>::undecided() {
  return d_.changes.open() && !knows_enough(&d_) && !waited_enough();
}

/// Motion that is too dull to fill the database can still tell.
template <class S>
bool Device<S>::waited_enough() {
  return d_.changes.open() && open_segments_ >= kMostUndecided * d_.database().capacity() && could_convict(&d_);
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
[[gnu::cold]] void Device<S>::read_filter(Release<S>* out, InformationAnalysis<S>* analysis) {
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
  Near<Segment<S>> segments[kMaxSegments];
  bool use[kMaxSegments];
  const int count = d_.database().in_order(segments);
  const bool known = calibrated_ && report_.release.status != Status::failed && !d_.options.joint_filter;
  d_.work.eliminator().restart();
  d_.calibrator().continue_with(segments, count, prior(), known ? d_.calibrator().theta() : working_theta(),
                                d_.options.model);
  for (int i = 0; i < count; ++i) use[i] = use_slot[segments[i] - &d_.database().slot(0)] != 0;
  return d_.calibrator().rows_of(use, candidates, &d_.work.eliminator());
}

template <class S>
std::uint64_t Device<S>::result_hash() const {
  Hash hash = trajectory_;
  add_to_hash(theta_, &hash);
  if (calibrated_) add_to_hash(report_.release, &hash);
  if (finished_) add_to_hash(d_.database(), &hash);
  if (finished_) add_to_hash(d_.epochs, &hash);
  return hash.value();
}

}  // namespace SEGCAL_NS
