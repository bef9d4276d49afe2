// The memory that background work shares, and the right to use it: one owner at a time.
//
// Who works takes a lease, works through it, and ends it. There is no other way to the memory, and no second lease
// before the first has ended. The ledger, in two parts (docs/porting.md, section 4):
//
//   block     an elimination's landmarks, then its chain  | between eliminations: Findings, of what was eliminated
//   triangle  the reduced system, until its rows are taken | after it: numbers, for sums, comparisons, a histogram
//
//   score         elimination | analysis | comparison with the kept segments; or condensing
//   calibration   eliminations | comparison of segments | scatter | residuals | release, until it takes effect
//   question      rows of the kept segments; what they predict; an epoch alone; analysis of the filter's own estimate
//
// Work in slices keeps its lease across pauses. A calibration that is done keeps it until it takes effect, while the
// database is closed and nothing is scored. A start in motion works in the filter's window (vio/start_motion.h).
#pragma once

#include "api/release.h"
#include "api/trigger.h"
#include "information/joint_information.h"
#include "information/metrics.h"
#include "segments/elimination.h"

namespace SEGCAL_NS {

enum class WorkOwner : std::int32_t { nobody, score, calibration, question };

template <class S>
class Workspace {
  template <int n>
  struct Numbers {
    S number[n];
  };
  struct Findings {
    S W[kMaxTheta * kMaxTheta];
    InformationAnalysis<S> analysis;
    Release<S> release;
    SegmentInformation<S> moved;
  };

 public:
  /// The right to use the memory. Stands in the same block of memory as the workspace, or on the stack.
  class Lease {
   public:
    Lease() = default;
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    /// An elimination ends what is in the block and in the triangle.
    SegmentEliminator<S>& eliminator() { return work().eliminator_; }

    /// An analysis to begin, in the block. A release and an epoch's rows stand beside it.
    InformationAnalysis<S>* new_analysis() {
      Findings& f = eliminator().template begin_in_block<Findings>();
      f.analysis.W = f.W;
      return &f.analysis;
    }
    InformationAnalysis<S>* analysis() { return &findings().analysis; }
    /// What the calibration under way will release.
    Release<S>* release() { return &findings().release; }
    /// An epoch's rows moved to another theta, while it is compared.
    SegmentInformation<S>* moved() { return &findings().moved; }

    /// An X in the triangle.
    template <class X>
    X& begin_in_triangle() {
      return eliminator().template begin_in_triangle<X>();
    }
    template <class X>
    X& in_triangle() {
      return eliminator().template in_triangle<X>();
    }
    /// n numbers there.
    template <int n>
    S* numbers() {
      return begin_in_triangle<Numbers<n>>().number;
    }
    /// Sums of information over theta's n columns, there.
    JointInformation<S> sums(const S* prior_sigma, int n) {
      return JointInformation<S>(prior_sigma, n, numbers<kJointScratch>());
    }

    void end() {
      work().owner_ = WorkOwner::nobody;
      work_ = nullptr;
    }

   private:
    friend class Workspace;
    Workspace& work() {
      eigen_assert(work_);
      return *work_;
    }
    Findings& findings() { return eliminator().template in_block<Findings>(); }
    NearOrNull<Workspace> work_;
  };

  [[gnu::noinline]] void begin_lease(WorkOwner owner, Lease* lease) {
    eigen_assert(owner_ == WorkOwner::nobody);
    owner_ = owner;
    eliminator_.restart();
    lease->work_ = this;
  }
  /// Ends whatever lease there is: its owner is no more.
  void reset() { owner_ = WorkOwner::nobody; }

 private:
  SegmentEliminator<S> eliminator_;
  WorkOwner owner_ = WorkOwner::nobody;
};

}  // namespace SEGCAL_NS
