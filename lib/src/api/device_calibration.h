// Device: a calibration from the kept segments or from the filter, and what it drops.
#pragma once

#include "api/device.h"

namespace SEGCAL_NS {

template <class S>
int Device<S>::background(int slices) {
  if (slices > 0 && calibration_due_) calibrate();
  return calibration_due_ ? 1 : 0;
}

template <class S>
void Device<S>::read_filter(Release<S>* out, InformationAnalysis<S>* analysis) {
  if (!vio_.knows_sensors()) return release_prior(prior_, out);
  const Calibration<S>& theta = vio_.calibration();
  PackedTriangle<S> R(analysis_.W, theta.columns() + 1);  // free between two scores
  vio_.calibration_information(&R);
  for (int i = theta.effect_column(); i < theta.columns(); ++i) R.row(i)[i] = S(1) / prior_.sigma[i];
  if (analysis) analyse_with_prior(R, prior_.sigma, analysis);
  judge_filter(theta, prior_, ReleaseRules<S>{}, &R, out);
}

template <class S>
void Device<S>::calibrate() {
  calibration_due_ = false;
  if (options_.joint_filter) {
    read_filter(&release_, &joint_);
    calibrated_ = true;
    theta_ = release_.theta;
    return;
  }
  fit();
  // Without the outdated ones theta is another, and there may be more that do not agree with that.
  for (int round = 0; round < kOutdatedRounds && drop_outdated(); ++round) fit();
  analyse_with_prior(calibrator_.theta_triangle(), prior_.sigma, &joint_);
  judge(&calibrator_, prior_, ReleaseRules<S>{}, &release_);
  calibrated_ = true;
  if (release_.status == Status::failed) {
    drop_misfits();
    return;
  }
  theta_ = release_.theta;
  monitor_.reset(prior_, theta_);
  use_stamp_shift();
  if (vio_.initialised()) vio_.set_calibration(theta_);
}

template <class S>
S Device<S>::linearise(const std::uint8_t* use_slot, const CandidateTerms& candidates) {
  Segment<S>* segments[kMaxSegments];
  bool use[kMaxSegments];
  const int count = database_.in_order(segments);
  const bool known = calibrated_ && release_.status != Status::failed && !options_.joint_filter;
  calibrator_.continue_with(segments, count, prior_, known ? calibrator_.theta() : working_theta(), options_.model);
  for (int i = 0; i < count; ++i) use[i] = use_slot[segments[i] - &database_.slot(0)] != 0;
  return calibrator_.rows_of(use, candidates, &eliminator_);
}

/// A segment has one shift for all of its keyframes: where it changes, the open one begins anew.
template <class S>
void Device<S>::use_stamp_shift() {
  const std::int32_t shift = stamp_shift(theta_);
  if (shift == stamp_shift_ns_) return;
  if (pending_count_ > 0) pending_time_ += shift - stamp_shift_ns_;
  stamp_shift_ns_ = shift;
  if (builder_.empty()) return;
  ++serial_;
  thinned_ = 0;
  builder_.begin(&database_.building(), session_, serial_, false);
}

template <class S>
void Device<S>::fit() {
  Segment<S>* segments[kMaxSegments];
  const int count = database_.in_order(segments);
  calibrator_.begin(segments, count, prior_, working_theta(), options_.model);
  calibrator_.accept_all();
  CalibratorOptions rough;
  rough.converged = rough.settled = 0.1;
  calibrator_.run(rough, &eliminator_);
  // Corners that are still far off once the model fits are no noise: they are left out, and the rest fits again.
  calibrator_.reject_outliers(S(5));
  calibrator_.run(CalibratorOptions{}, &eliminator_);
}

/// Drops segments that newer ones contradict (calibration/agreement.h); true if there were any. All are scored again at
/// the calibrated theta, each alone: what a segment says must not come from its neighbours.
template <class S>
bool Device<S>::drop_outdated() {
  Segment<S>* segments[kMaxSegments];
  const SegmentInformation<S>* information[kMaxSegments];
  const int count = database_.in_order(segments);
  if (count < 3 || !calibrator_.fit().converged || !(options_.outdated_level > S(0))) return false;
  for (int i = 0; i < count; ++i) {
    eliminator_.eliminate(*segments[i], GuestLink<S>{}, calibrator_.theta(), options_.model, S(0));
    eliminator_.extract(&segments[i]->information);
    information[i] = &segments[i]->information;
  }
  static_assert(Agreement<S>::kScratch <= ReducedSystem<S>::kScratch, "the eliminator has too little to lend");
  Agreement<S> newer(prior_, calibrator_.theta(), options_.outdated_level / S(count - 1), noise_of(information, count), &joint_,
                     eliminator_.reduced().scratch());
  const std::uint32_t before = faults_.segments_outdated;
  for (int i = count - 1; i >= 0; --i) {
    if (!newer.outdated(*information[i])) continue;
    database_.drop_outdated(segments[i]);
    ++faults_.segments_outdated;
  }
  if (faults_.segments_outdated == before) return false;
  knew_enough_ = knew_enough_ && knows_enough();
  return true;
}

/// After a failed calibration: segments that do not fit even alone leave the database, and collecting goes on.
template <class S>
void Device<S>::drop_misfits() {
  for (int i = 0; i < Database<S>::kSlots; ++i) {
    if (!database_.kept(i)) continue;
    const Segment<S>& segment = database_.slot(i);
    const S cost = segment_cost(segment, GuestLink<S>{}, calibrator_.theta(), options_.model);
    if (cost <= ReleaseRules<S>{}.most_chi2_per_dof * S(segment.information.dof)) continue;
    database_.drop(i);
    ++faults_.segments_unsettled;
  }
  knew_enough_ = knew_enough_ && knows_enough();
}

}  // namespace SEGCAL_NS
