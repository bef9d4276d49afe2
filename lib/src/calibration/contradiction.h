// Does a segment that is to be condensed fit what is known of theta? A device that fell does not say so, and what it
// measures from then on must not go into the epoch of what it was before.
//
// Known are the prior, the kept segments (each alone) and older epochs, K; the
// newest epoch, E; and the segment says s; all moved to E's theta_0. Folding rows
// into a triangle leaves over what they say otherwise than those before (epoch.h):
//   s after K and E     a change at this moment
//   what E and s leave over after K, less what s leaves over after E: a change when E began, of which no segment is
//   sure alone.
// Each is chi-square with n degrees of freedom if theta is the same, times what segments that agreed left over: F, with
// that excess in few directions (spread.h). That mean counts directions that no segment shows, where all agree, so it
// is taken to be at least the variance that sigmas are scaled for.
#pragma once

#include "calibration/epochs.h"
#include "calibration/scatter.h"
#include "calibration/spread.h"
#include "database/database.h"
#include "math/small_solvers.h"

namespace SEGCAL_NS {

/// Probability of a false alarm in one comparison. It costs the segment, and an answer until a calibration has decided
/// what is outdated; a day has 20,000 segments, with two comparisons each. What is not found at once has moved an epoch
/// by a fraction of what the limit allows.
constexpr double kFalseAlarm = 1e-5;
/// Camera, gyroscope and accelerometer: what a segment scatters beyond noise may be of all three, in kScattering
/// directions each. Were it taken to sit in three directions altogether, a camera that turns by 0.5 deg while its
/// tracks drift would be noticed half a minute later.
constexpr int kSensors = 3;

/// What a segment's rows pull at the optimum of `known`, which
/// has them in it and the prior. `scratch`: SegmentScatter's.
template <class S>
[[gnu::cold]] Pull<S> pull_on(const SegmentInformation<S>& rows, const PackedTriangle<S>& known, S* scratch) {
  const int n = rows.n_theta;
  S theta[kMaxTheta];
  for (int i = 0; i < n; ++i) theta[i] = known(i, n);
  back_substitute(known, n, theta);
  SegmentScatter<S> scatter(known, n, scratch);
  while (!scatter.take_step(rows, theta)) {
  }
  return {scatter.found(), scatter.expected()};
}

template <class S>
class Contradiction {
 public:
  static constexpr int kScratch = 2 * packed_size(kMaxTheta + 1) + SegmentScatter<S>::kScratch;

  /// `variance`: of what is known over that of stated noise, at least 1: the square of what sigmas are scaled by.
  void begin(S variance) {
    variance_ = variance;
    spread_ = {};
    place_ = n_kept_ = 0;
    found_ = false;
  }
  /// `rows`: [theta | rhs] of the segment, linearised at the newest epoch's theta_0. `kept_at`: where the kept
  /// segments' information is. In slices; true when found() tells.
  [[gnu::cold]] bool step(const SegmentInformation<S>& rows, const Epochs<S>& epochs, const Database<S>& database,
                          const ThetaPrior<S>& prior, const Calibration<S>& kept_at, S* scratch) {
    const int newest = epochs.count() - 1;
    const Epoch<S>& E = epochs.epoch(newest);
    PackedTriangle<S> known(scratch, E.columns() + 1), own(scratch + packed_size(E.columns() + 1), E.columns() + 1);
    S* rest = scratch + 2 * packed_size(E.columns() + 1);
    SEGCAL_SLICES(place_) {
      write_prior(prior, E.theta, &known);
      for (i_ = 0; i_ < Database<S>::kSlots; ++i_) {
        if (!database.kept(i_)) continue;
        fold_moved(database.slot(i_).information, kept_at, E.theta, &known);
        take_left_over(&known, n_kept_++ > 0);  // the first one tells of the start's error
        SEGCAL_PAUSE(place_);
      }
      for (i_ = 0; i_ < newest; ++i_) {
        fold_moved(epochs.epoch(i_).information, epochs.epoch(i_).theta, E.theta, &known);
        take_left_over(&known, true);
        SEGCAL_PAUSE(place_);
      }
      own.clear();
      fold_moved(E.information, E.theta, E.theta, &own);
      SEGCAL_PAUSE(place_);
      fold_moved(rows, E.theta, E.theta, &own);
      among_ = left_over(own);
      SEGCAL_PAUSE(place_);
      fold_moved(E.information, E.theta, E.theta, &known);
      epoch_ = left_over(known);
      SEGCAL_PAUSE(place_);
      fold_moved(rows, E.theta, E.theta, &known);
      both_ = left_over(known);
      decide(E.columns());
      SEGCAL_PAUSE(place_);
      pull_ = pull_on(rows, known, rest);
    }
    SEGCAL_SLICES_END(place_);
  }
  bool found() const { return found_; }
  /// The larger of the two comparisons, a chi-square number where the segment agrees.
  S misfit() const { return both_ - (epoch_ < among_ ? epoch_ : among_); }
  /// It is rather the whole newest epoch than this segment. Of an epoch that agrees
  /// with K and is worth as much as the segment, the second comparison has less than
  /// half of the first beyond noise; of one that does not, or says little, more.
  bool since_epoch() const { return since_ >= S(0.5) * now_; }
  /// The segment's, on all that is known with it.
  const Pull<S>& pull() const { return pull_; }

 private:
  static S left_over(const PackedTriangle<S>& T) {
    return T(T.columns() - 1, T.columns() - 1) * T(T.columns() - 1, T.columns() - 1);
  }

  void take_left_over(PackedTriangle<S>* T, bool counts) {
    const int n = T->columns() - 1;
    if (counts) spread_.add(left_over(*T), n);
    T->row(n)[n] = S(0);
  }
  void decide(int n) {
    spread_.raise_to(variance_);
    const S limit = spread_.uneven_limit(n, S(kFalseAlarm), kSensors), noise = S(n) * spread_.mean();
    const S now = both_ - epoch_, since = both_ - among_;
    found_ = limit > S(0) && (now > since ? now : since) > limit * noise;
    now_ = now - noise;
    since_ = since - noise;
  }

  Place place_ = 0;
  std::int32_t i_ = 0, n_kept_ = 0;
  Spread<S> spread_;
  S variance_ = S(1), among_ = S(0), epoch_ = S(0), both_ = S(0);
  S now_ = S(0), since_ = S(0);  ///< the two comparisons, beyond noise
  Pull<S> pull_;
  bool found_ = false;
};

}  // namespace SEGCAL_NS
