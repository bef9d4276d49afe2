// The eliminator, and its memory while it does not eliminate: one owner, who lends it to one job at a time.
//
//   block     one landmark's rows or the chain's, while a segment is eliminated
//             | after it: W and the directions of the analysis under way, and what a calibration releases, until it
//             takes effect
//   triangle  of the reduced system, while a segment is eliminated and until its rows are taken
//             | after it: sums of information, the comparison of segments or their scatter
//
// Two jobs cannot hold it together: a device works on one job at a time (Device::step), and a calibration that is done
// holds it until it takes effect, while the database is closed and nothing is scored. Builds with SEGCAL_ASSERT check
// that.
#pragma once

#include <new>

#include "api/release.h"
#include "api/trigger.h"
#include "calibration/agreement.h"
#include "calibration/scatter.h"
#include "information/joint_information.h"
#include "information/metrics.h"
#include "segments/elimination.h"

namespace SEGCAL_NS {

/// Residuals' lengths of all image points, while they are counted.
struct LengthHistogram {
  static constexpr int kBins = 400, kBinsPerPixel = 100;  ///< what is beyond counts in the last
  std::int32_t bin[kBins];

  template <class S>
  static int place_of(S length_px) {
    return length_px < S(kBins) / S(kBinsPerPixel) ? static_cast<int>(length_px * S(kBinsPerPixel)) : kBins - 1;
  }
  /// px, of `n` lengths.
  template <class S>
  S median(std::int32_t n) const {
    std::int32_t below = 0;
    int i = 0;
    while (i < kBins - 1 && 2 * (below += bin[i]) < n) ++i;
    return (S(i) + S(0.5)) / S(kBinsPerPixel);
  }
};

enum class WorkOwner : std::int32_t { nobody, score, calibration };

template <class S>
class Workspace {
 public:
  SegmentEliminator<S>& eliminator() { return eliminator_; }

  /// Takes the memory for a job; give_back() ends that.
  void take(WorkOwner owner) {
    eigen_assert(owner_ == WorkOwner::nobody);
    owner_ = owner;
    eliminator_.restart();
  }
  void give_back() { owner_ = WorkOwner::nobody; }

  /// An analysis to begin, with its memory W. Elimination ends it.
  InformationAnalysis<S>* new_analysis() {
    Lent* lent = new (eliminator_.lend()) Lent;
    lent->analysis.W = lent->W;
    return &lent->analysis;
  }
  const InformationAnalysis<S>& analysis() { return lent().analysis; }
  InformationAnalysis<S>* analysis_under_way() { return &lent().analysis; }
  /// What the calibration under way will release.
  Release<S>* release() { return &lent().release; }

  /// An epoch's rows moved to another theta, while it is compared.
  SegmentInformation<S>* moved() { return &lent().moved; }

  /// Sums of information over theta's n columns. Elimination ends them.
  JointInformation<S> sums(const S* prior_sigma, int n) {
    static_assert(kJointScratch <= ReducedSystem<S>::kScratch, "the triangle is too small for sums of information");
    return JointInformation<S>(prior_sigma, n, eliminator_.reduced().scratch());
  }
  /// For the comparison of segments.
  S* agreement_scratch() {
    static_assert(Agreement<S>::kScratch <= ReducedSystem<S>::kScratch,
                  "the triangle is too small to compare segments");
    return eliminator_.reduced().scratch();
  }
  /// For their scatter.
  S* scatter_scratch() {
    static_assert(SegmentScatter<S>::kScratch <= ReducedSystem<S>::kScratch,
                  "the triangle is too small for the scatter of segments");
    return eliminator_.reduced().scratch();
  }
  LengthHistogram* histogram() {
    static_assert(sizeof(LengthHistogram) <= sizeof(S) * ReducedSystem<S>::kScratch,
                  "the triangle is too small for a histogram");
    return static_cast<LengthHistogram*>(static_cast<void*>(eliminator_.reduced().scratch()));
  }

 private:
  struct Lent {
    S W[kMaxTheta * kMaxTheta];
    InformationAnalysis<S> analysis;
    Release<S> release;
    SegmentInformation<S> moved;
  };
  static_assert(sizeof(Lent) <= SegmentEliminator<S>::kLentBytes, "the eliminator has too little to lend");
  Lent& lent() { return *static_cast<Lent*>(eliminator_.lend()); }

  SegmentEliminator<S> eliminator_;
  WorkOwner owner_ = WorkOwner::nobody;
};

}  // namespace SEGCAL_NS
