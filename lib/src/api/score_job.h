// What a segment that has ended is worth: closed, eliminated, analysed, compared, offered to the database (paper, Alg.
// 1), in slices. It stays in the slot where it was built; the next one begins in memory that only a calibration needs.
#pragma once

#include "api/parts.h"
#include "api/report.h"
#include "calibration/kept_epoch.h"
#include "segments/visible_translation.h"

namespace SEGCAL_NS {

/// What becomes of the segment.
template <class S>
struct Condensing {
  bool on = false;           ///< it goes into the newest epoch, not into the database
  bool last_chance = false;  ///< if it cannot, as those before it, the database is emptied
  S variance = S(1);         ///< of what is known, over that of stated noise
};

template <class S>
class ScoreJob {
 public:
  [[gnu::cold]] ScoreJob() = default;
  void reset() { active_ = false; }
  bool active() const { return active_; }
  /// Of the segment in the building slot, at `theta`. Returns where the next segment is built until this is done.
  Segment<S>* begin(const Calibration<S>& theta, const Condensing<S>& condensing, DeviceParts<S>* d) {
    active_ = true;
    condensing_ = condensing;
    judged_ = emptied_ = false;
    d->condenser.restart();
    place_ = 0;
    theta_ = theta;
    d->slices.begin_job();
    d->work.begin_lease(WorkOwner::score, &work_);
    d->builder.restart_close();
    largest_.restart();
    d->calibrator().begin_costs();
    return &d->calibrator().begin_spare_segment();
  }
  /// One slice; the last one publishes. The open segment must then move to the building slot.
  void step(DeviceParts<S>* d, ScoreReport<S>* report) {
    d->slices.count();
    if (!score_step(d, report)) return;
    d->slices.score = d->slices.job;
    work_.end();
    active_ = false;
  }
  /// The scored segment was to go into an epoch; and it told enough for that to be tried.
  bool condenses() const { return condensing_.on; }
  bool judged() const { return judged_; }
  /// It contradicts what is known, or fits as little as those before it: what the kept segments said is an epoch now.
  bool emptied() const { return emptied_; }
  /// Then: of the newest segment of what it contradicts.
  std::uint32_t session_before() const { return session_before_; }
  /// theta as known when the segment ended.
  const Calibration<S>& theta() const { return theta_; }
  /// The scored segment was kept.
  bool kept() const { return kept_; }

 private:
  [[gnu::cold]] bool score_step(DeviceParts<S>* d, ScoreReport<S>* report);
  [[gnu::cold]] bool condense_step(DeviceParts<S>* d);
  bool compare_step(DeviceParts<S>* d);
  bool empty_step(DeviceParts<S>* d);
  [[gnu::cold]] void begin_emptying(DeviceParts<S>* d);
  [[gnu::cold]] bool analyse_segment_step(DeviceParts<S>* d, Segment<S>* segment);
  void settle(DeviceParts<S>* d, const Segment<S>& segment);
  void publish(DeviceParts<S>* d, ScoreReport<S>* report);

  bool active_ = false, settled_ = false, kept_ = false, judged_ = false, emptied_ = false;
  Condensing<S> condensing_;
  /// A segment whose states have not come to their ends contradicts anything: with little motion attitude and the
  /// accelerometer's bias are hardly told apart, and two Gauss-Newton steps (condenser.h) leave them 15 deg from there.
  /// So before it raises an alarm a segment is settled by two more, up to three times, until what it contradicts by
  /// changes by less than a hundredth: of a true change by 0 to 3 % in the second round and nothing in the third, of
  /// states on their way by 4 % and more.
  static constexpr int kMostRounds = 4;
  static constexpr double kSettled = 0.01;
  std::int32_t round_ = 0;
  bool contradicts_ = false, moves_ = false;
  S misfit_ = S(0);  ///< of the last comparison
  Place place_ = 0, inner_ = 0, compare_place_ = 0, empty_place_ = 0;
  std::uint32_t session_before_ = 0;
  Calibration<S> theta_;
  LargestEigenvalue<S> largest_;
  typename Workspace<S>::Lease work_;
  Near<S> numbers_;           ///< in the workspace, while a segment is condensed
  CondenseMemory<S> memory_;  ///< the calibrator's
  std::conditional_t<(kEpochs > 0), Contradiction<S>, NoCondenser> contradiction_;
  std::conditional_t<(kEpochs > 0), KeptEpoch<S>, NoCondenser> kept_epoch_;
  Near<Segment<S>> kept_segment_[kEpochs > 0 ? kMaxSegments : 1];  ///< while the database is emptied
  std::int32_t n_kept_ = 0, nth_ = 0;
  Near<Epoch<S>> epoch_of_kept_;
  JointInformation<S> sums_;
};

template <class S>
[[gnu::cold]] bool ScoreJob<S>::score_step(DeviceParts<S>* d, ScoreReport<S>* report) {
  Segment<S>& segment = d->database().building();
  const MeasurementModel<S>& model = d->options.model;
  SEGCAL_SLICES(place_) {
    kept_ = false;
    inner_ = 0;
    SEGCAL_AWAIT(place_, d->builder.close_step(&segment, theta_, model));
    if (SegmentBuilder<S>::useful(segment)) {
      SEGCAL_PAUSE(place_);
      segment.turned_only = segment.wide_depth_prior = !translation_shows(segment, theta_, model);
      SEGCAL_PAUSE(place_);
      SEGCAL_AWAIT(place_, work_.eliminator().eliminate_step(segment, GuestLink<S>{}, theta_, model, S(0),
                                                             d->monitor.candidates()));
      SEGCAL_PAUSE(place_);
      work_.eliminator().extract(&segment.information);
      SEGCAL_PAUSE(place_);
      SEGCAL_AWAIT(place_, d->calibrator().costs().inertial_step(segment, GuestLink<S>{}, theta_, model));
      SEGCAL_PAUSE(place_);
      settle(d, segment);
      SEGCAL_PAUSE(place_);
      SEGCAL_AWAIT(place_, analyse_segment_step(d, &segment));
      sums_ = work_.sums(d->prior().sigma, theta_.columns());
      if (settled_ && !condensing_.on) {
        SEGCAL_AWAIT(place_, d->database().compare_step(&sums_));
        SEGCAL_PAUSE(place_);
      }
      publish(d, report);
      SEGCAL_AWAIT(place_, condense_step(d));
    } else {
      d->condenser.break_chain();
      ++d->faults.segments_discarded;
    }
  }
  SEGCAL_SLICES_END(place_);
}

template <class S>
[[gnu::cold]] bool ScoreJob<S>::analyse_segment_step(DeviceParts<S>* d, Segment<S>* segment) {
  InformationAnalysis<S>* a = inner_ == 0 ? work_.new_analysis() : work_.analysis();
  SEGCAL_SLICES(inner_) {
    begin_analysis(segment->information, d->prior().sigma, a);
    SEGCAL_AWAIT(inner_, analyse_step(segment->information.n_theta, a));
    segment->metrics = metrics_but_E(a, d->prior().sigma, d->options.sigma_ref);
    SEGCAL_AWAIT(inner_, largest_.step(a->W, a->n));
    segment->metrics.E = largest_.value();
    SEGCAL_PAUSE(inner_);
  }
  SEGCAL_SLICES_END(inner_);
}

/// Whether the segment may be kept; and what it says about the
/// effects that are watched, while the eliminator still holds it.
template <class S>
void ScoreJob<S>::settle(DeviceParts<S>* d, const Segment<S>& segment) {
  const bool effects = theta_.effects.count() > 0 || d->monitor.active();
  settled_ = follows_its_imu(segment, d->calibrator().costs().inertial(), effects);
  if (settled_) {
    d->monitor.add(&work_.eliminator(), theta_);
  } else {
    ++d->faults.segments_unsettled;
  }
}

template <class S>
void ScoreJob<S>::publish(DeviceParts<S>* d, ScoreReport<S>* report) {
  report->segment = summary_of(d->database().building());
  report->segment.settled = settled_;
  kept_ = settled_ && !condensing_.on && d->database().offer_compared(&sums_);
  report->segment.kept = kept_;
  report->directions.copy(*work_.analysis());
}

}  // namespace SEGCAL_NS

#include "api/score_condense.h"
