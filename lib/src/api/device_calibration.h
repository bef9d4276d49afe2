// Device: a calibration from the kept segments or from the filter, and what it drops.
#pragma once

#include "api/device.h"
#include "math/resumable.h"

namespace SEGCAL_NS {

/// One slice of the work that waits; false if there is none.
template <class S>
bool Device<S>::step() {
  if (vio_.start_pending()) {
    vio_.start_step(imu_);
  } else if (scoring_) {
    scoring_ = !score_step();
  } else if (calibrating_) {
    calibrating_ = !calibrate_step();
  } else {
    return false;
  }
  return true;
}

template <class S>
int Device<S>::background(int slices) {
  while (slices > 0 && step()) --slices;
  return vio_.start_pending() || scoring_ || calibrating_ ? 1 : 0;
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
void Device<S>::calibrate() {
  finish_score();
  if (window_ > 0) finish_calibration();
  if (options_.joint_filter) {
    ++faults_.calibrations;
    read_filter(&release_, &joint_);
    calibrated_ = true;
    theta_ = release_.theta;
    return;
  }
  begin_calibration(working_theta());
  finish_calibration();
}

/// From the segments that are kept now; none of them is replaced before it takes effect.
template <class S>
void Device<S>::begin_calibration(const Calibration<S>& theta) {
  ++faults_.calibrations;
  known_theta_ = theta;
  n_taking_part_ = database_.in_order(taking_part_);
  eliminator_.restart();
  calibrate_place_ = inner_place_ = 0;
  calibrating_ = true;
}

/// Does what is left of it, and lets it take effect.
template <class S>
void Device<S>::finish_calibration() {
  while (calibrating_) calibrating_ = !calibrate_step();
  window_ = 0;
  take_release();
}

template <class S>
bool Device<S>::calibrate_step() {
  CalibratorOptions rough;
  rough.converged = rough.settled = 0.1;
  SEGCAL_SLICES(calibrate_place_) {
    for (round_ = 0;; ++round_) {
      calibrator_.begin(taking_part_, n_taking_part_, prior(), known_theta_, options_.model);
      SEGCAL_PAUSE(calibrate_place_);
      calibrator_.accept_all();
      SEGCAL_PAUSE(calibrate_place_);
      SEGCAL_AWAIT(calibrate_place_, calibrator_.run_step(rough, &eliminator_));
      SEGCAL_PAUSE(calibrate_place_);
      // Corners that are still far off once the model fits are no noise: they are left out, and the rest fits again.
      SEGCAL_AWAIT(calibrate_place_, calibrator_.reject_outliers_step(S(5)));
      SEGCAL_PAUSE(calibrate_place_);
      SEGCAL_AWAIT(calibrate_place_, calibrator_.run_step(CalibratorOptions{}, &eliminator_));
      if (round_ == kOutdatedRounds) break;
      // Without the outdated ones theta is another, and there may be more that do not agree with that.
      SEGCAL_AWAIT(calibrate_place_, drop_outdated_step());
      if (!dropped_) break;
      n_taking_part_ = database_.in_order(taking_part_);
    }
    SEGCAL_PAUSE(calibrate_place_);
    begin_analysis_with_prior(calibrator_.theta_triangle(), prior().sigma, &joint_);
    SEGCAL_AWAIT(calibrate_place_, analyse_with_prior_step(theta_.columns(), &joint_));
    SEGCAL_PAUSE(calibrate_place_);
    judge(&calibrator_, prior(), ReleaseRules<S>{}, &release_);
    calibrated_ = true;
    if (release_.status == Status::failed) SEGCAL_AWAIT(calibrate_place_, drop_misfits_step());
  }
  SEGCAL_SLICES_END(calibrate_place_);
}

template <class S>
void Device<S>::take_release() {
  if (release_.status == Status::failed) return;
  theta_ = release_.theta;
  monitor_.reset(prior(), theta_);
  use_stamp_shift();
  if (vio_.initialised()) vio_.set_calibration(theta_);
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
  builder_.begin(&open_slot(), session_, serial_, false);
}

template <class S>
S Device<S>::linearise(const std::uint8_t* use_slot, const CandidateTerms& candidates) {
  finish_score();  // eliminator and calibrator are needed
  if (window_ > 0) finish_calibration();
  Segment<S>* segments[kMaxSegments];
  bool use[kMaxSegments];
  const int count = database_.in_order(segments);
  const bool known = calibrated_ && release_.status != Status::failed && !options_.joint_filter;
  calibrator_.continue_with(segments, count, prior(), known ? calibrator_.theta() : working_theta(), options_.model);
  for (int i = 0; i < count; ++i) use[i] = use_slot[segments[i] - &database_.slot(0)] != 0;
  return calibrator_.rows_of(use, candidates, &eliminator_);
}

/// Drops segments that newer ones contradict (calibration/agreement.h); dropped_ says whether there were any. All are scored
/// again at the calibrated theta, each alone: what a segment says must not come from its neighbours.
template <class S>
bool Device<S>::drop_outdated_step() {
  static_assert(Agreement<S>::kScratch <= ReducedSystem<S>::kScratch, "the eliminator has too little to lend");
  SEGCAL_SLICES(inner_place_) {
    dropped_ = false;
    if (n_taking_part_ >= 3 && calibrator_.fit().converged && options_.outdated_level > S(0)) {
      for (i_ = 0; i_ < n_taking_part_; ++i_) {
        SEGCAL_AWAIT(inner_place_, eliminator_.eliminate_step(*taking_part_[i_], GuestLink<S>{}, calibrator_.theta(), options_.model, S(0)));
        eliminator_.extract(&taking_part_[i_]->information);
        SEGCAL_PAUSE(inner_place_);
      }
      begin_agreement();
      for (i_ = n_taking_part_ - 1; i_ >= 0; --i_) {
        SEGCAL_AWAIT(inner_place_, agreement_.take_step(taking_part_[i_]->information));
        if (!agreement_.outdated()) continue;
        database_.drop_outdated(taking_part_[i_]);
        ++faults_.segments_outdated;
        dropped_ = true;
      }
      if (dropped_) knew_enough_ = knew_enough_ && knows_enough();
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

template <class S>
void Device<S>::begin_agreement() {
  const SegmentInformation<S>* information[kMaxSegments];
  for (int i = 0; i < n_taking_part_; ++i) information[i] = &taking_part_[i]->information;
  agreement_ = Agreement<S>(prior(), calibrator_.theta(), options_.outdated_level / S(n_taking_part_ - 1),
                            noise_of(information, n_taking_part_), &joint_, eliminator_.reduced().scratch());
}

/// After a failed calibration: segments that do not fit even alone leave the database, and collecting goes on.
template <class S>
bool Device<S>::drop_misfits_step() {
  SEGCAL_SLICES(inner_place_) {
    calibrator_.lend_cost_steps();
    for (i_ = 0; i_ < Database<S>::kSlots; ++i_) {
      if (!database_.kept(i_)) continue;
      SEGCAL_AWAIT(inner_place_, calibrator_.cost_steps().step(database_.slot(i_), GuestLink<S>{}, calibrator_.theta(), options_.model));
      if (calibrator_.cost_steps().total() <= ReleaseRules<S>{}.most_chi2_per_dof * S(database_.slot(i_).information.dof)) continue;
      database_.drop(i_);
      ++faults_.segments_unsettled;
    }
    knew_enough_ = knew_enough_ && knows_enough();
  }
  SEGCAL_SLICES_END(inner_place_);
}

}  // namespace SEGCAL_NS
