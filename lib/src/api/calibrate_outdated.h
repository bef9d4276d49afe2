// CalibrateJob: segments and epochs that tell of a calibration the
// device no longer has, and whether that is a change of the device.
#pragma once

#include "api/calibrate_job.h"

namespace SEGCAL_NS {

/// Drops segments and epochs that newer ones contradict
/// (calibration/agreement.h); dropped_ says whether there were any.
template <class S>
[[gnu::cold]] bool CalibrateJob<S>::drop_outdated_step(DeviceParts<S>* d) {
  SEGCAL_SLICES(inner_) {
    dropped_ = false;
    if (n_ + d->epochs.count() >= 3 && d->calibrator().fit().converged && d->options.outdated_level > S(0)) {
      begin_agreement(d);
      epoch_ = newest_epoch(d);
      for (i_ = n_ - 1; i_ >= 0 || epoch_ >= 0; compares_epoch_ ? --epoch_ : --i_) {
        compare_next(d);
        SEGCAL_AWAIT(inner_, agreement_.take_step(compares_epoch_ ? *work_.moved() : segment_[i_]->information));
        take_verdict(d);
      }
      SEGCAL_PAUSE(inner_);
      if (agreement_.confirmed()) {
        for (i_ = 0; kHistory > 0 && i_ < n_; ++i_) {
          if (!convicted_[i_]) continue;
          remember(*segment_[i_], d->calibrator().theta(), d);
          SEGCAL_PAUSE(inner_);
        }
        drop_convicted(d);
        judge_change(d);
      }
    }
  }
  SEGCAL_SLICES_END(inner_);
}

/// Place of the newest epoch that says anything: one may have just begun.
template <class S>
int CalibrateJob<S>::newest_epoch(DeviceParts<S>* d) {
  if constexpr (kEpochs > 0)
    return d->epochs.count() - (d->epochs.count() > 0 && d->epochs.newest().segments == 0 ? 2 : 1);
  return -1;
}

/// Of segment i_ and epoch_, the newer one is next.
template <class S>
void CalibrateJob<S>::compare_next(DeviceParts<S>* d) {
  compares_epoch_ = false;
  if constexpr (kEpochs > 0) {
    compares_epoch_ = epoch_ >= 0 && (i_ < 0 || d->epochs.epoch(epoch_).last_serial > segment_[i_]->serial);
    if (compares_epoch_) d->epochs.epoch(epoch_).move_to(d->calibrator().theta(), work_.moved());
  }
}

/// An epoch that agrees tells what its segments disagree by among themselves: one of several may convict the next older
/// item, though it is one item.
template <class S>
void CalibrateJob<S>::take_verdict(DeviceParts<S>* d) {
  if (compares_epoch_) {
    if constexpr (kEpochs > 0) {
      const Epoch<S>& e = d->epochs.epoch(epoch_);
      agreement_.know_spread(e.pulls.found, static_cast<int>(e.pulls.expected));
      convicted_epoch_[epoch_] = agreement_.outdated();
    }
  } else {
    convicted_[i_] = agreement_.outdated();
  }
}

/// What is outdated goes.
template <class S>
void CalibrateJob<S>::drop_convicted(DeviceParts<S>* d) {
  for (int i = 0; i < n_; ++i) {
    if (!convicted_[i]) continue;
    d->database().drop_outdated(segment_[i]);
    ++d->faults.segments_outdated;
    dropped_ = true;
  }
  if constexpr (kEpochs > 0) {
    for (int i = newest_epoch(d); i >= 0; --i) {
      if (!convicted_epoch_[i]) continue;
      outdate_epoch(i, d);
      dropped_ = true;
    }
  }
  dropped_any_ = dropped_any_ || dropped_;
}

/// Variance of whitened residuals as the segments show it each with a theta of its own; 1 where it is less than stated.
template <class S>
S noise_of(const SegmentInformation<S>* const* segment, int count) {
  S chi2 = S(0), dof = S(0);
  for (int i = 0; i < count; ++i) {
    chi2 += segment[i]->rho2();
    dof += S(segment[i]->dof - segment[i]->n_theta);
  }
  return dof > S(0) && chi2 > dof ? chi2 / dof : S(1);
}

template <class S>
void CalibrateJob<S>::begin_agreement(DeviceParts<S>* d) {
  const SegmentInformation<S>* information[kMaxSegments];
  for (int i = 0; i < n_; ++i) information[i] = &segment_[i]->information;
  const S comparisons = S(n_ + d->epochs.count() - 1);
  agreement_ =
      Agreement<S>(d->prior(), d->calibrator().theta(), d->options.outdated_level / comparisons,
                   noise_of(information, n_), work_.new_analysis(), work_.template numbers<Agreement<S>::kScratch>());
}

/// Entries may be known too little for any of them to be sure alone: 0.5 deg are four sigmas of a rotation that a short
/// drive hardly tells from the principal point, and twenty of what it does tell.
template <class S>
void CalibrateJob<S>::judge_change(DeviceParts<S>* d) {
  if constexpr (kEpochs > 0) changed_ = changed_ || (d->changes.open() && agreement_.changed(S(kFalseChange)));
}

/// Epochs that theta has left tell less (Epoch::widen_for). True if there are any, and theta is to be found again.
template <class S>
bool CalibrateJob<S>::widen_far_epochs(DeviceParts<S>* d) {
  bool widened = false;
  if constexpr (kEpochs > 0) {
    if (!d->calibrator().fit().converged) return false;
    S* scratch = work_.template numbers<Epoch<S>::kScratch>();
    for (int i = 0; i < d->epochs.count(); ++i) {
      if (d->epochs.widen(i, d->calibrator().theta(), d->prior(), scratch)) widened = true;
    }
  }
  return widened;
}

}  // namespace SEGCAL_NS
