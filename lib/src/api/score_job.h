// What a segment that has ended is worth: closed, eliminated, analysed, compared, offered to the database (paper, Alg. 1), in
// slices. It stays in the slot where it was built; the next one begins in memory that only a calibration needs.
#pragma once

#include "api/parts.h"
#include "api/report.h"
#include "calibration/contradiction.h"
#include "segments/visible_translation.h"

namespace SEGCAL_NS {

template <class S>
class ScoreJob {
 public:
  void reset() { active_ = false; }
  bool active() const { return active_; }
  /// Of the segment in the building slot, at `theta`. Returns where the next segment is built until this is done.
  /// `condense`: it goes into the newest epoch, not into the database.
  Segment<S>* begin(const Calibration<S>& theta, bool condense, DeviceParts<S>* d) {
    active_ = true;
    condense_ = condense;
    judged_ = contradicts_ = false;
    d->condenser.restart();
    place_ = 0;
    theta_ = theta;
    d->slices.begin_job();
    d->work.take(WorkOwner::score);
    d->builder.restart_close();
    largest_.restart();
    Segment<S>* spare = d->calibrator.lend_segment();
    d->calibrator.lend_cost_steps();
    return spare;
  }
  /// One slice; the last one publishes. The open segment must then move to the building slot.
  void step(DeviceParts<S>* d, ScoreReport<S>* report) {
    d->slices.count();
    if (!score_step(d, report)) return;
    d->slices.score = d->slices.job;
    d->work.give_back();
    active_ = false;
  }
  /// The scored segment was to go into an epoch; and it told enough for that to be tried.
  bool condenses() const { return condense_; }
  bool judged() const { return judged_; }
  /// It, or the newest epoch with it, contradicts what was known before.
  bool contradicts() const { return contradicts_; }
  /// Not it alone, but all of that epoch.
  bool contradicts_since_epoch() const { return contradiction_.since_epoch(); }
  /// theta as known when the segment ended.
  const Calibration<S>& theta() const { return theta_; }
  /// The scored segment was kept.
  bool kept() const { return kept_; }

 private:
  bool score_step(DeviceParts<S>* d, ScoreReport<S>* report);
  bool condense_step(DeviceParts<S>* d);
  bool analyse_segment_step(DeviceParts<S>* d, Segment<S>* segment);
  void settle(DeviceParts<S>* d, const Segment<S>& segment);
  void publish(DeviceParts<S>* d, ScoreReport<S>* report);

  bool active_ = false, settled_ = false, kept_ = false, condense_ = false, judged_ = false, contradicts_ = false;
  Place place_ = 0, inner_ = 0;
  Calibration<S> theta_;
  LargestEigenvalue<S> largest_;
  CondenseMemory<S> memory_;   ///< lent by the calibrator
  std::conditional_t<(kEpochs > 0), Contradiction<S>, NoCondenser> contradiction_;
  JointInformation<S> sums_;
};

template <class S>
bool ScoreJob<S>::score_step(DeviceParts<S>* d, ScoreReport<S>* report) {
  Segment<S>& segment = d->database.building();
  const MeasurementModel<S>& model = d->options.model;
  SEGCAL_SLICES(place_) {
    kept_ = false;
    inner_ = 0;
    SEGCAL_AWAIT(place_, d->builder.close_step(&segment, theta_, model));
    if (SegmentBuilder<S>::useful(segment)) {
      SEGCAL_PAUSE(place_);
      segment.turned_only = segment.wide_depth_prior = !translation_shows(segment, theta_, model);
      SEGCAL_PAUSE(place_);
      SEGCAL_AWAIT(place_, d->work.eliminator().eliminate_step(segment, GuestLink<S>{}, theta_, model, S(0), d->monitor.candidates()));
      SEGCAL_PAUSE(place_);
      d->work.eliminator().extract(&segment.information);
      SEGCAL_PAUSE(place_);
      SEGCAL_AWAIT(place_, d->calibrator.cost_steps().inertial_step(segment, GuestLink<S>{}, theta_, model));
      SEGCAL_PAUSE(place_);
      settle(d, segment);
      SEGCAL_PAUSE(place_);
      SEGCAL_AWAIT(place_, analyse_segment_step(d, &segment));
      sums_ = d->work.sums(d->prior().sigma, theta_.columns());
      if (settled_ && !condense_) {
        SEGCAL_AWAIT(place_, d->database.compare_step(&sums_));
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
bool ScoreJob<S>::analyse_segment_step(DeviceParts<S>* d, Segment<S>* segment) {
  InformationAnalysis<S>* a = d->work.analysis_under_way();
  SEGCAL_SLICES(inner_) {
    a = d->work.new_analysis();
    begin_analysis(segment->information, d->prior().sigma, a);
    SEGCAL_AWAIT(inner_, analyse_step(segment->information.n_theta, a));
    segment->metrics = metrics_but_E(a, d->prior().sigma, d->options.sigma_ref);
    SEGCAL_AWAIT(inner_, largest_.step(a->W, a->n));
    segment->metrics.E = largest_.value();
    SEGCAL_PAUSE(inner_);
  }
  SEGCAL_SLICES_END(inner_);
}

/// Whether the segment may be kept; and what it says about the effects that are watched, while the eliminator still holds it.
template <class S>
void ScoreJob<S>::settle(DeviceParts<S>* d, const Segment<S>& segment) {
  const bool effects = theta_.effects.count() > 0 || d->monitor.active();
  settled_ = follows_its_imu(segment, d->calibrator.cost_steps().inertial(), effects);
  if (settled_) {
    d->monitor.add(&d->work.eliminator(), theta_);
  } else {
    ++d->faults.segments_unsettled;
  }
}

template <class S>
void ScoreJob<S>::publish(DeviceParts<S>* d, ScoreReport<S>* report) {
  report->segment = summary_of(d->database.building());
  kept_ = settled_ && !condense_ && d->database.offer_compared(&sums_);
  report->segment.kept = kept_;
  report->directions.copy(d->work.analysis());
}

/// After its report is out: elimination ends the analysis.
template <class S>
bool ScoreJob<S>::condense_step(DeviceParts<S>* d) {
  if constexpr (kEpochs > 0) {
    SEGCAL_SLICES(inner_) {
      judged_ = condense_;
      if (condense_ && !settled_) d->condenser.break_chain();
      if (condense_ && settled_) {
        memory_ = d->calibrator.lend_condense_memory(&d->work.eliminator());
        SEGCAL_AWAIT(inner_, d->condenser.step(&d->database.building(), d->options.model, memory_, &d->epochs.newest()));
        if (d->condenser.condensed()) {
          SEGCAL_PAUSE(inner_);
          static_assert(Contradiction<S>::kScratch <= Agreement<S>::kScratch, "the triangle is too small for the comparison");
          contradiction_.restart();
          SEGCAL_AWAIT(inner_, contradiction_.step(d->database.building().information, d->epochs, d->database, d->prior(),
                                                   d->calibrator.theta(), d->work.agreement_scratch()));
          contradicts_ = contradiction_.found();
        }
        if (d->condenser.condensed() && !contradicts_) {
          d->condenser.take(&d->database.building(), memory_, contradiction_.pull(), &d->epochs.newest());
        } else {
          d->condenser.break_chain();
          ++d->faults.segments_unsettled;
        }
      }
    }
    SEGCAL_SLICES_END(inner_);
  }
  return true;
}

}  // namespace SEGCAL_NS
