// A segment that ended after the first release goes into an epoch, or contradicts what is known: then what was known is
// closed, and the database collects anew.
#pragma once

#include "api/score_job.h"

namespace SEGCAL_NS {

/// After its report is out: elimination ends the analysis.
template <class S>
bool ScoreJob<S>::condense_step(DeviceParts<S>* d) {
  if constexpr (kEpochs > 0) {
    SEGCAL_SLICES(inner_) {
      judged_ = condensing_.on;
      compare_place_ = empty_place_ = 0;
      contradicts_ = false;
      if (condensing_.on && settled_) {
        for (round_ = 0; round_ < kMostRounds; ++round_) {
          SEGCAL_AWAIT(inner_, compare_step(d));
          if (!contradicts_ || !moves_) break;
        }
        if (d->condenser.condensed() && !contradicts_) {
          d->condenser.take(&d->database().building(), memory_, contradiction_.pull(), &d->epochs.newest());
          remember(d->database().building(), d->epochs.newest().theta, d);
        } else {
          d->condenser.break_chain();
          ++d->faults.segments_unsettled;
          emptied_ = contradicts_ || condensing_.last_chance;
        }
      } else if (condensing_.on) {
        d->condenser.break_chain();
        emptied_ = condensing_.last_chance;
      }
      if (emptied_) {
        begin_emptying(d);
        SEGCAL_AWAIT(inner_, empty_step(d));
      }
    }
    SEGCAL_SLICES_END(inner_);
  }
  return true;
}

/// Condenses the segment and compares it with what is known; from the second round on from where it is.
template <class S>
bool ScoreJob<S>::compare_step(DeviceParts<S>* d) {
  SEGCAL_SLICES(compare_place_) {
    memory_ = d->calibrator().begin_condensing(&work_.eliminator());
    contradiction_.begin(condensing_.variance);
    SEGCAL_AWAIT(compare_place_, d->condenser.step(&d->database().building(), d->options.model, memory_,
                                                   &d->epochs.newest(), round_ > 0));
    SEGCAL_PAUSE(compare_place_);
    if (d->condenser.condensed()) {
      numbers_ = work_.template numbers<Contradiction<S>::kScratch>();
      SEGCAL_AWAIT(compare_place_, contradiction_.step(d->database().building().information, d->epochs, d->database(),
                                                       d->prior(), d->calibrator().theta(), numbers_));
      contradicts_ = contradiction_.found();
      moves_ = round_ == 0 || absolute(contradiction_.misfit() - misfit_) > S(kSettled) * misfit_;
      misfit_ = contradiction_.misfit();
      SEGCAL_PAUSE(compare_place_);
    } else {
      moves_ = false;  // what contradicted before does still
    }
  }
  SEGCAL_SLICES_END(compare_place_);
}

/// Since when, and where to. A misfit contradicts all that is known.
template <class S>
void ScoreJob<S>::begin_emptying(DeviceParts<S>* d) {
  session_before_ = 0;
  const int known = d->epochs.count() - (contradicts_ && contradiction_.since_epoch() ? 1 : 0);
  for (int i = 0; i < known; ++i) {
    const Epoch<S>& e = d->epochs.epoch(i);
    if (e.segments > 0 && e.last_session > session_before_) session_before_ = e.last_session;
  }
  n_kept_ = d->database().in_order(kept_segment_);
  if (n_kept_ == 0) return;
  const Segment<S>& newest = *kept_segment_[n_kept_ - 1];
  if (newest.session > session_before_) session_before_ = newest.session;
  epoch_of_kept_ = &d->epochs.insert(d->calibrator().theta(), kept_segment_[0]->session, newest.serial);
}

/// What the kept segments say becomes an epoch, and the database is free for segments that can be linearised again: the
/// next calibration compares them with all epochs, and drops what they contradict (agreement.h).
template <class S>
bool ScoreJob<S>::empty_step(DeviceParts<S>* d) {
  SEGCAL_SLICES(empty_place_) {
    SEGCAL_PAUSE(empty_place_);
    if (n_kept_ > 0) {
      kept_epoch_.restart();
      numbers_ = work_.template numbers<KeptEpoch<S>::kScratch>();
      SEGCAL_AWAIT(empty_place_, kept_epoch_.step(kept_segment_, n_kept_, d->prior(), epoch_of_kept_, numbers_));
      for (nth_ = 0; nth_ < n_kept_; ++nth_) {
        remember(*kept_segment_[nth_], epoch_of_kept_->theta, d);
        d->database().drop(static_cast<int>(kept_segment_[nth_] - &d->database().slot(0)));
        SEGCAL_PAUSE(empty_place_);
      }
    }
  }
  SEGCAL_SLICES_END(empty_place_);
}

}  // namespace SEGCAL_NS
