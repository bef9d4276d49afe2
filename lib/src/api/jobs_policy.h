// Jobs: what follows from a score and from a calibration, when a
// calibration is worth its time, and when segments go into epochs.
#pragma once

#include "api/jobs.h"

namespace SEGCAL_NS {

/// The open segment moves to the slot that is free now. A calibration
/// follows if the scored segment was the one that was missing.
template <class S>
void Jobs<S>::end_score(DeviceParts<S>* d) {
  d->builder.move_to(&d->database().building());
  if (d->options.joint_filter) return;  // segments of the caller's own odometry are scored, no more
  if (score_.condenses()) count_misfits(d);
  open_segments_ = d->changes.open() ? open_segments_ + 1 : 0;
  const bool enough = worth_a_calibration(d);
  knew_enough_ = knew_enough_ || enough;
  wanted_then_ = wanted_then_ && !undecided(d);
  if (wanted_then_ || (enough && d->options.calibrates_itself)) begin_calibration(score_.theta(), d);
}

/// The kept segments tell enough for the first time; or as many were condensed since the last calibration as it was
/// made from: where theta_0 comes from half of what is known, later epochs are linearised near enough (Epoch::bent_at).
template <class S>
bool Jobs<S>::worth_a_calibration(DeviceParts<S>* d) {
  if (waited_enough(d)) return true;
  if (score_.emptied()) return false;
  if (!score_.condenses()) return score_.kept() && !knew_enough_ && knows_enough(d);
  if constexpr (kEpochs > 0) return d->epochs.segments() + d->database().size() >= 2 * made_from_;
  return false;
}

/// Nobody scores while a calibration is under way.
template <class S>
void Jobs<S>::publish(const Calibration<S>& known, DeviceParts<S>* d) {
  window_ = 0;
  while (calibration_.working()) step(d);
  const bool dropped = calibration_.publish(d, &report_);
  if constexpr (kEpochs > 0) {
    made_from_ = d->epochs.segments() + d->database().size();
    if (calibration_.changed() && report_.release.status == Status::calibrated) {
      d->changes.decide(known, report_.release.theta, report_.release.sigma);
    }
    d->changes.close();  // no change: a false alarm; not calibrated: that is what the result says now
  }
  ++d->faults.calibrations_published;
  calibrated_ = true;
  if (dropped) knew_enough_ = knew_enough_ && knows_enough(d);
  set_condensing(d);
}

/// From a released theta on, as long as the database holds what it was made from: another segment in it would push one
/// out that nothing else remembers. Where theta cannot be released, epochs are no help to find out why.
template <class S>
void Jobs<S>::set_condensing(DeviceParts<S>* d) {
  if (report_.release.status == Status::failed) forget_epochs(d);
  condensing_ = kEpochs > 0 && d->options.condense && report_.release.status == Status::calibrated &&
                (d->epochs.count() > 0 || knows_enough(d));
  new_epoch_ = true;
  misfits_ = 0;
  d->condenser.break_chain();
}

template <class S>
void Jobs<S>::forget_epochs(DeviceParts<S>* d) {
  if constexpr (kEpochs > 0) d->faults.segments_outdated += static_cast<std::uint32_t>(d->epochs.segments());
  d->epochs.clear();
  d->changes.close();
  d->history.clear();
}

/// Where a segment contradicts what is known, or one after the other fits no longer, theta may be another than epochs
/// were made at: the database collects anew.
template <class S>
void Jobs<S>::count_misfits(DeviceParts<S>* d) {
  if constexpr (kEpochs > 0) {
    if (!score_.judged()) return;
    misfits_ = d->condenser.condensed() ? 0 : misfits_ + 1;
    if (!score_.emptied()) return;
    misfits_ = 0;
    condensing_ = knew_enough_ = false;
    d->changes.open(score_.session_before(), scored_.segment.session, scored_.segment.start_ns, report_.release.sigma,
                    score_.theta().columns());
  }
}

/// What came since contradicts what was known, and is not enough to tell which is right: what was released stays,
/// however long that takes. A calibration that could not convict what is older would confirm it.
template <class S>
bool Jobs<S>::undecided(DeviceParts<S>* d) {
  return d->changes.open() && !knows_enough(d) && !waited_enough(d);
}

/// Motion that is too dull to fill the database can still tell.
template <class S>
bool Jobs<S>::waited_enough(DeviceParts<S>* d) {
  return d->changes.open() && open_segments_ >= kMostUndecided * d->database().capacity() && could_convict(d);
}

}  // namespace SEGCAL_NS
