// The work on segments that have ended: one queue, one active job, and when what it finds takes effect.
//
// A segment that has ended is scored; when it was the one that was missing, or when it is asked for, a calibration
// follows. There is memory for one segment that is scored and one that is built. While a calibration is under way the
// database is closed; it takes effect at the end of the `calibration_window`-th segment after it began, or at the first
// later end at which it is done, so that results do not depend on how fast slices are done. The device says when a
// segment has ended and what a released calibration moves (device_work.h); the filter's start in motion is the filter's
// own work (vio/start_motion.h).
#pragma once

#include "api/calibrate_job.h"
#include "api/score_job.h"

namespace SEGCAL_NS {

/// So many segments in a row that do not fit into an epoch are no accident.
constexpr int kMostMisfits = 3;
/// Segments scored while a change is open, over those that the database
/// holds, until a calibration decides with fewer than it holds.
constexpr int kMostUndecided = 3;

template <class S>
struct StoredFields;  // store/stored_fields.h

template <class S>
class Jobs {
  friend struct StoredFields<S>;

 public:
  [[gnu::cold]] Jobs() = default;
  [[gnu::cold]] void reset();
  /// Another session: it has to know enough by itself.
  [[gnu::cold]] void begin_session(DeviceParts<S>* d);

  /// A score or a calibration is under way, or a calibration waits for its moment.
  bool pending() const { return score_.active() || calibration_.pending(); }
  bool scoring() const { return score_.active(); }
  bool calibrating() const { return calibration_.working(); }
  /// Until it takes effect.
  bool calibration_pending() const { return calibration_.pending(); }
  /// Slices of a job are left.
  bool working() const { return scoring() || calibrating(); }
  /// Nothing has been begun since all that was pending was finished.
  bool finished() const { return finished_; }
  void set_finished() { finished_ = true; }
  /// Ends of segments until the calibration under way takes effect, if it is done by then; 0: there is none.
  int ends_left() const { return window_; }

  /// One slice; false if there is none.
  [[gnu::noinline]] bool step(DeviceParts<S>* d);
  /// The filter has no start pending (Device::finish_start): that comes first.
  void finish_score(DeviceParts<S>* d) {
    while (score_.active()) step(d);
  }

  /// Of the segment in the building slot; nothing is pending. `theta`: to score at; `known`: as released, for an epoch.
  [[gnu::cold]] void begin_score(const Calibration<S>& theta, const Calibration<S>& known, std::uint32_t session,
                                 DeviceParts<S>* d);
  /// Where the open segment is built.
  Segment<S>& open_slot(DeviceParts<S>* d) { return score_.active() ? *spare_ : d->database().building(); }

  /// A calibration after the next segment that is scored, or by flush_step().
  void request() { wanted_ = true; }
  bool requested() const { return wanted_; }
  /// One that was asked for, or nothing where an open change is undecided. Nothing else is pending.
  [[gnu::cold]] void begin_requested(const Calibration<S>& theta, DeviceParts<S>* d);
  /// A segment has ended while a calibration is under way. True if it is to take effect now.
  bool count_end(bool at_once, DeviceParts<S>* d);
  /// Does what is left of the calibration under way, and publishes its report. `known`: as released before.
  [[gnu::cold]] void publish(const Calibration<S>& known, DeviceParts<S>* d);
  /// A report that no job made: of the filter's own calibration.
  CalibrationReport<S>* publish_without_job() {
    wanted_ = false;
    calibrated_ = true;
    return &report_;
  }

  /// As published by the last calibration that took effect.
  const CalibrationReport<S>& report() const { return report_; }
  bool has_report() const { return calibrated_; }
  bool released() const { return calibrated_ && report_.release.status == Status::calibrated; }
  const ScoreReport<S>& last_scored() const { return scored_; }

 private:
  [[gnu::cold]] void end_score(DeviceParts<S>* d);
  [[gnu::cold]] void begin_calibration(const Calibration<S>& theta, DeviceParts<S>* d);
  bool worth_a_calibration(DeviceParts<S>* d);
  void count_misfits(DeviceParts<S>* d);
  bool undecided(DeviceParts<S>* d);
  bool waited_enough(DeviceParts<S>* d);
  void set_condensing(DeviceParts<S>* d);
  void forget_epochs(DeviceParts<S>* d);

  ScoreJob<S> score_;
  CalibrateJob<S> calibration_;
  ScoreReport<S> scored_;
  CalibrationReport<S> report_;
  Near<Segment<S>> spare_;      ///< where the open segment stands while the one before is scored
  std::int32_t window_;         ///< > 0: segment ends until a calibration takes effect, if it is done then
  std::int32_t misfits_;        ///< segments in a row that could not be condensed
  std::int32_t made_from_;      ///< segments, kept and condensed, that the last calibration was made from
  std::int32_t open_segments_;  ///< scored while a change was open
  bool calibrated_, knew_enough_;
  bool condensing_, new_epoch_;  ///< segments that end go into epochs; the next one begins another
  bool wanted_;                  ///< a calibration was asked for since the last segment that is scored ended
  bool wanted_then_;             ///< it was before: it begins when that segment has been scored
  bool finished_;                ///< nothing has been begun since all that was pending was finished
};

template <class S>
void Jobs<S>::reset() {
  report_.release = Release<S>{};
  report_.directions.n = scored_.directions.n = 0;
  scored_.segment = SegmentSummary<S>{};
  score_.reset();
  calibration_.reset();
  window_ = misfits_ = made_from_ = open_segments_ = 0;
  calibrated_ = knew_enough_ = condensing_ = wanted_ = wanted_then_ = false;
  new_epoch_ = finished_ = true;
}

template <class S>
void Jobs<S>::begin_session(DeviceParts<S>* d) {
  knew_enough_ = false;
  if (d->options.strategy == Strategy::single_session) {
    d->epochs.clear();
    d->changes.close();
    d->history.clear();
    condensing_ = false;
  }
  new_epoch_ = true;  // between sessions a device may change: what the new one says is held against all before
}

template <class S>
bool Jobs<S>::step(DeviceParts<S>* d) {
  if (score_.active()) {
    score_.step(d, &scored_);
    if (!score_.active()) end_score(d);
  } else if (calibration_.working()) {
    calibration_.step(d);
  } else {
    return false;
  }
  return true;
}

template <class S>
void Jobs<S>::begin_score(const Calibration<S>& theta, const Calibration<S>& known, std::uint32_t session,
                          DeviceParts<S>* d) {
  finished_ = false;
  wanted_then_ = wanted_;
  wanted_ = false;
  if constexpr (kEpochs > 0) {
    if (condensing_ && new_epoch_) d->epochs.begin(known, session);
  }
  new_epoch_ = new_epoch_ && !condensing_;
  const S scale = report_.release.noise_scale;
  spare_ = score_.begin(theta, {condensing_, misfits_ + 1 >= kMostMisfits, scale * scale}, d);
}

template <class S>
void Jobs<S>::begin_calibration(const Calibration<S>& theta, DeviceParts<S>* d) {
  wanted_then_ = false;
  finished_ = false;
  calibration_.begin(theta, d);
  window_ = d->options.calibration_window;
}

template <class S>
void Jobs<S>::begin_requested(const Calibration<S>& theta, DeviceParts<S>* d) {
  wanted_ = false;
  if (!undecided(d)) begin_calibration(theta, d);
}

template <class S>
bool Jobs<S>::count_end(bool at_once, DeviceParts<S>* d) {
  ++d->faults.segments_missed;
  if (window_ > 1) {
    --window_;
    return false;
  }
  if (calibration_.working() && !at_once) {
    ++d->faults.slices_late;
    return false;
  }
  return true;
}

}  // namespace SEGCAL_NS

#include "api/jobs_policy.h"
