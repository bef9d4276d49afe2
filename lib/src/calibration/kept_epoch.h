// The kept segments become an epoch, so that the database is free
// for others: each with what it says alone, without its links.
#pragma once

#include "calibration/contradiction.h"

namespace SEGCAL_NS {

template <class S>
class KeptEpoch {
 public:
  static constexpr int kScratch = 2 * packed_size(kMaxTheta + 1) + SegmentScatter<S>::kScratch;
  void restart() { place_ = 0; }
  /// `segments`: in order of time, with information at epoch->theta.
  /// `scratch`: kScratch numbers. In slices; true when all are in the epoch.
  template <class Pointer>
  [[gnu::cold]] bool step(const Pointer* segments, int count, const ThetaPrior<S>& prior, Epoch<S>* epoch, S* scratch) {
    const int n = epoch->columns();
    PackedTriangle<S> known(scratch, n + 1);
    SEGCAL_SLICES(place_) {
      write_prior(prior, epoch->theta, &known);
      for (i_ = 0; i_ < count; ++i_) {
        fold_moved(segments[i_]->information, epoch->theta, epoch->theta, &known);
        SEGCAL_PAUSE(place_);
        // The first one's pull tells of the start's error.
        pull_ = i_ > 0 ? pull_on(segments[i_]->information, known, scratch + 2 * packed_size(n + 1)) : Pull<S>{};
        SEGCAL_PAUSE(place_);
        take(segments[i_], epoch);
        SEGCAL_PAUSE(place_);
      }
    }
    SEGCAL_SLICES_END(place_);
  }

 private:
  void take(Segment<S>* segment, Epoch<S>* epoch) {
    epoch->add(segment->information.triangle(), S(segment->information.dof), pull_, segment->session, segment->serial);
    for (int o = 0; o < segment->n_observations; ++o) epoch->image_points += segment->observation[o].rejected ? 0 : 1;
  }

  Place place_ = 0;
  std::int32_t i_ = 0;
  Pull<S> pull_;
};

}  // namespace SEGCAL_NS
