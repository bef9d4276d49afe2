// A calibration from the kept segments, in slices: fit, without outliers, without segments that newer ones contradict;
// then what of it is released. Nobody sees anything of it before it is published, whole (report.h).
#pragma once

#include "api/length_histogram.h"
#include "api/parts.h"
#include "api/report.h"
#include "calibration/agreement.h"
#include "calibration/course_trial.h"
#include "calibration/scatter.h"

namespace SEGCAL_NS {

constexpr int kOutdatedRounds = 2;

template <class S>
class CalibrateJob {
 public:
  [[gnu::cold]] CalibrateJob() = default;
  void reset() { stage_ = Stage::idle; }
  /// Slices are left.
  bool working() const { return stage_ == Stage::working; }
  /// Begun and not yet published: its segments are being moved.
  bool pending() const { return stage_ != Stage::idle; }

  /// From the segments that are kept now; none of them is replaced before it is published.
  void begin(const Calibration<S>& theta, DeviceParts<S>* d) {
    ++d->faults.calibrations;
    d->slices.begin_job();
    d->work.begin_lease(WorkOwner::calibration, &work_);
    theta_ = theta;
    n_ = d->database().in_order(segment_);
    place_ = inner_ = 0;
    dropped_any_ = changed_ = false;
    stage_ = Stage::working;
  }
  void step(DeviceParts<S>* d) {
    d->slices.count();
    if (!calibrate_step(d)) return;
    d->slices.calibration = d->slices.job;
    stage_ = Stage::done;
  }
  /// What was found, when no slices are left. True if segments left the database.
  bool publish(DeviceParts<S>* d, CalibrationReport<S>* report) {
    report->release = *work_.release();
    report->theta = d->calibrator().theta();
    report->fit = d->calibrator().fit();
    report->segments = d->database().size();
    report->partitions = d->calibrator().partitions();
    report->reprojection = reprojection_;
    report->directions.copy(*work_.analysis());
    if constexpr (kHistory > 0) report->course = course_;
    work_.end();
    stage_ = Stage::idle;
    return dropped_any_;
  }

  /// What it dropped as outdated tells of another theta than what it kept: decisive, all taken together.
  bool changed() const { return changed_; }

 private:
  enum class Stage : std::int32_t { idle, working, done };
  [[gnu::cold]] bool calibrate_step(DeviceParts<S>* d);
  [[gnu::cold]] bool fit_step(DeviceParts<S>* d);
  [[gnu::cold]] bool score_alone_step(DeviceParts<S>* d);
  [[gnu::cold]] bool drop_outdated_step(DeviceParts<S>* d);
  [[gnu::cold]] bool measure_scatter_step(DeviceParts<S>* d);
  [[gnu::cold]] bool drop_misfits_step(DeviceParts<S>* d);
  [[gnu::cold]] bool measure_residuals_step(DeviceParts<S>* d);
  void add_residuals(DeviceParts<S>* d, const Segment<S>& s);
  bool widen_far_epochs(DeviceParts<S>* d);
  static void outdate_epoch(int i, DeviceParts<S>* d) {
    d->faults.segments_outdated += static_cast<std::uint32_t>(d->epochs.epoch(i).segments);
    d->epochs.drop(i);
  }
  static int newest_epoch(DeviceParts<S>* d);
  void compare_next(DeviceParts<S>* d);
  void take_verdict(DeviceParts<S>* d);
  void drop_convicted(DeviceParts<S>* d);
  [[gnu::cold]] void begin_agreement(DeviceParts<S>* d);
  void judge_change(DeviceParts<S>* d);
  [[gnu::cold]] bool judge_course_step(DeviceParts<S>* d);
  void hold_lag(const ThetaPrior<S>& prior);
  CourseItem<S> course_item(int i, const DeviceParts<S>& d) const;

  Stage stage_ = Stage::idle;
  Place place_ = 0, inner_ = 0;
  typename Workspace<S>::Lease work_;
  Calibration<S> theta_;                    ///< where it begins
  Near<Segment<S>> segment_[kMaxSegments];  ///< that take part, in order of time
  std::int32_t n_ = 0, i_ = 0, epoch_ = 0, round_ = 0;
  bool dropped_ = false, dropped_any_ = false, changed_ = false, compares_epoch_ = false;
  Agreement<S> agreement_;
  bool convicted_[kMaxSegments] = {}, convicted_epoch_[kEpochs > 0 ? kEpochs : 1] = {};  ///< by agreement_
  SegmentScatter<S> scatter_;
  std::conditional_t<(kHistory > 0), CourseTrial<S>, NoCourse> trial_;
  std::conditional_t<(kHistory > 0), Course<S>, NoCourse> course_;
  ReprojectionFigures<S> reprojection_;
  double squares_ = 0;
  std::int32_t points_ = 0, left_out_ = 0;
};

template <class S>
[[gnu::cold]] bool CalibrateJob<S>::calibrate_step(DeviceParts<S>* d) {
  SEGCAL_SLICES(place_) {
    for (round_ = 0;; ++round_) {
      SEGCAL_AWAIT(place_, fit_step(d));
      SEGCAL_AWAIT(place_, score_alone_step(d));
      if (round_ >= kOutdatedRounds) break;
      // Without the outdated ones theta is another, and there may be more that do not agree with that.
      SEGCAL_AWAIT(place_, drop_outdated_step(d));
      // Only then: where theta is another, it is the newest that is far from where it was linearised, and right.
      if (!dropped_ && !widen_far_epochs(d)) break;
      n_ = d->database().in_order(segment_);
    }
    SEGCAL_PAUSE(place_);
    SEGCAL_AWAIT(place_, measure_scatter_step(d));
    SEGCAL_AWAIT(place_, measure_residuals_step(d));
    begin_analysis_with_prior(d->calibrator().theta_triangle(), d->prior().sigma, work_.new_analysis());
    SEGCAL_AWAIT(place_, analyse_with_prior_step(theta_.columns(), work_.analysis()));
    SEGCAL_PAUSE(place_);
    judge(&d->calibrator(), d->prior(), ReleaseRules<S>{}, scatter_.variance(), work_.release());
    if (work_.release()->status == Status::failed) SEGCAL_AWAIT(place_, drop_misfits_step(d));
    SEGCAL_AWAIT(place_, judge_course_step(d));
  }
  SEGCAL_SLICES_END(place_);
}

template <class S>
bool CalibrateJob<S>::fit_step(DeviceParts<S>* d) {
  CalibratorOptions rough;
  rough.converged = rough.settled = 0.1;
  Calibrator<S>& calibrator = d->calibrator();
  SEGCAL_SLICES(inner_) {
    calibrator.begin(segment_, n_, d->prior(), theta_, d->options.model);
    if constexpr (kEpochs > 0) calibrator.take_epochs(&d->epochs);
    SEGCAL_PAUSE(inner_);
    calibrator.accept_all();
    SEGCAL_PAUSE(inner_);
    SEGCAL_AWAIT(inner_, calibrator.run_step(rough, &work_.eliminator()));
    SEGCAL_PAUSE(inner_);
    // Corners that are still far off once the model fits are no noise: they are left out, and the rest fits again.
    SEGCAL_AWAIT(inner_, calibrator.reject_outliers_step(S(5)));
    SEGCAL_PAUSE(inner_);
    SEGCAL_AWAIT(inner_, calibrator.run_step(CalibratorOptions{}, &work_.eliminator()));
  }
  SEGCAL_SLICES_END(inner_);
}

/// All segments' information at the calibrated theta, each
/// alone: what a segment says must not come from its neighbours.
template <class S>
bool CalibrateJob<S>::score_alone_step(DeviceParts<S>* d) {
  SegmentEliminator<S>& eliminator = work_.eliminator();
  SEGCAL_SLICES(inner_) {
    for (i_ = 0; d->calibrator().fit().converged && i_ < n_; ++i_) {
      SEGCAL_AWAIT(inner_, eliminator.eliminate_step(*segment_[i_], GuestLink<S>{}, d->calibrator().theta(),
                                                     d->options.model, S(0)));
      eliminator.extract(&segment_[i_]->information);
      SEGCAL_PAUSE(inner_);
    }
  }
  SEGCAL_SLICES_END(inner_);
}

/// Do the segments that took part agree as far as noise lets them (calibration/scatter.h)? One alone cannot say.
template <class S>
[[gnu::cold]] bool CalibrateJob<S>::measure_scatter_step(DeviceParts<S>* d) {
  SEGCAL_SLICES(inner_) {
    scatter_ = SegmentScatter<S>(d->calibrator().theta_triangle(), theta_.columns(),
                                 work_.template numbers<SegmentScatter<S>::kScratch>());
    for (i_ = 0; d->calibrator().fit().converged && n_ >= 2 && i_ < n_; ++i_) {
      SEGCAL_AWAIT(inner_, scatter_.take_step(segment_[i_]->information));
    }
    if constexpr (kEpochs > 0) {
      for (int i = 0; i < d->epochs.count(); ++i)
        scatter_.add(d->epochs.epoch(i).pulls.found, d->epochs.epoch(i).pulls.expected);
    }
  }
  SEGCAL_SLICES_END(inner_);
}

/// After a failed calibration: segments that do not fit even alone leave the database, and collecting goes on.
template <class S>
bool CalibrateJob<S>::drop_misfits_step(DeviceParts<S>* d) {
  SEGCAL_SLICES(inner_) {
    d->calibrator().begin_costs();
    for (i_ = 0; i_ < Database<S>::kSlots; ++i_) {
      if (!d->database().kept(i_)) continue;
      SEGCAL_AWAIT(inner_, d->calibrator().costs().step(d->database().slot(i_), GuestLink<S>{}, d->calibrator().theta(),
                                                        d->options.model));
      if (d->calibrator().costs().total() <=
          ReleaseRules<S>{}.most_chi2_per_dof * S(d->database().slot(i_).information.dof))
        continue;
      d->database().drop(i_);
      ++d->faults.segments_unsettled;
      dropped_any_ = true;
    }
  }
  SEGCAL_SLICES_END(inner_);
}

template <class S>
bool CalibrateJob<S>::measure_residuals_step(DeviceParts<S>* d) {
  SEGCAL_SLICES(inner_) {
    for (std::int32_t& b : work_.template begin_in_triangle<LengthHistogram>().bin) b = 0;
    squares_ = 0;
    points_ = left_out_ = 0;
    for (i_ = 0; i_ < n_; ++i_) {
      add_residuals(d, *segment_[i_]);
      SEGCAL_PAUSE(inner_);
    }
    reprojection_ = {};
    if (points_ > left_out_) reprojection_.rms = square_root(S(squares_ / (points_ - left_out_)));
    if (points_ > 0) reprojection_.median = work_.template in_triangle<LengthHistogram>().template median<S>(points_);
  }
  SEGCAL_SLICES_END(inner_);
}

template <class S>
void CalibrateJob<S>::add_residuals(DeviceParts<S>* d, const Segment<S>& s) {
  std::int32_t* bin = work_.template in_triangle<LengthHistogram>().bin;
  for (int o = 0; o < s.n_observations; ++o) {
    const Observation& z = s.observation[o];
    Vec2<S> r;
    if (!point_residual(s, z, d->calibrator().theta(), d->options.model.g, s.states.landmark[z.landmark], &r)) continue;
    const S square = r.squaredNorm(), length = square_root(square);
    ++bin[LengthHistogram::place_of(length)];
    ++points_;
    left_out_ += z.rejected;
    if (!z.rejected) squares_ += static_cast<double>(square);
  }
}

}  // namespace SEGCAL_NS

#include "api/calibrate_course.h"
#include "api/calibrate_outdated.h"
