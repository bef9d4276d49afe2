// Levenberg-Marquardt over the kept segments (paper, Sec. V-D; docs/design.md, section 7).
//
// Each iteration eliminates every segment to theta, the ties and its separators, solves
// the small dense triangle of ties and theta, walks the chain back and substitutes each
// segment's states. Nothing grows with the number of segments but one row block each, and, where there is memory for
// it, what is kept of each to go back (kept_eliminations.h).
#pragma once

#include "calibration/calibration_fit.h"
#include "calibration/chain.h"
#include "calibration/condenser.h"
#include "calibration/epochs.h"
#include "calibration/fit_memory.h"
#include "calibration/global_system.h"
#include "calibration/kept_eliminations.h"
#include "calibration/partitions.h"
#include "calibration/step_policy.h"
#include "math/one_of.h"
#include "math/small_solvers.h"
#include "segments/segment_cost.h"
#include "segments/triangulation.h"
#include "segments/visible_translation.h"

namespace SEGCAL_NS {

template <class S>
struct StoredFields;  // store/stored_fields.h

template <class S>
class Calibrator {
  friend struct StoredFields<S>;

 public:
  /// Sets up a problem over `segments` (`Pointer` to Segment<S>, in time order within each session; count <=
  /// kMaxSegments). Their states are moved by run(). The prior must stay where it is.
  template <class Pointer>
  void begin(const Pointer* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
             const MeasurementModel<S>& model);
  template <class Pointer>
  void begin(const Pointer* segments, int count, ThetaPrior<S>&& prior, const Calibration<S>& theta,
             const MeasurementModel<S>& model) = delete;
  /// The same to look at the segments only: they stay as they are, and so does the fit of the last calibration.
  template <class Pointer>
  void continue_with(const Pointer* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                     const MeasurementModel<S>& model);
  /// Told by epochs too, from begin() on. They must stay as they are while a fit is under way.
  void take_epochs(const Epochs<S>* epochs) { epochs_ = epochs; }
  /// Iterates to convergence.
  void run(const CalibratorOptions& options, SegmentEliminator<S>* eliminator) {
    while (!run_step(options, eliminator)) {
    }
  }
  /// The same in slices (math/resumable.h). Between two of them the eliminator is not the caller's.
  [[gnu::cold]] bool run_step(const CalibratorOptions& options, SegmentEliminator<S>* eliminator);

  // While no run is under way, jobs work here (api/score_job.h, api/calibrate_job.h).
  /// Costs of single segments.
  CostSteps<S>& begin_costs() { return work_.template begin<CostSteps<S>>(); }
  CostSteps<S>& costs() { return work_.template get<CostSteps<S>>(); }
  /// To condense a segment; costs end with it.
  CondenseMemory<S> begin_condensing(SegmentEliminator<S>* eliminator) {
    return {eliminator, &work_.template begin<Chain<S>>(), step_};
  }
  /// Where the next segment is built meanwhile.
  Segment<S>& begin_spare_segment() { return memory_.begin_spare_segment(); }

  const Calibration<S>& theta() const { return theta_; }
  const CalibrationFit<S>& fit() const { return fit_; }
  /// Triangle over [theta | rhs] at the last linearisation, prior included: Sigma_theta = (R'R)^-1.
  PackedTriangle<S> theta_triangle() { return global_.theta_triangle(); }
  const SegmentLink<S>& link(int i) const { return link_[i]; }
  int count() const { return count_; }
  /// Place of a segment in the chain; -1 if it took no part.
  int place_of(const Segment<S>* segment) const {
    for (int i = 0; i < count_; ++i) {
      if (segment_[i] == segment) return i;
    }
    return -1;
  }
  /// One gauge is held in each.
  int partitions() const { return partition_count_; }
  /// Segments and ties that have a frame in common.
  Partitions<S>& grouping() { return partitions_; }
  const Ties<S>& ties() const { return partitions_.ties(); }
  /// Leaves out image points whose residual is longer than `limit` times the noise that the fit shows; earlier marks
  /// are taken back. Between runs, so that each run has one smooth cost.
  bool reject_outliers_step(S limit);
  void reject_outliers(S limit) {
    while (!reject_outliers_step(limit)) {
    }
  }
  /// The first run of a calibration takes the wide prior everywhere:
  /// which segments only turned shows when it has settled.
  void accept_all();
  const MeasurementModel<S>& model() const { return model_; }
  /// Eliminates everything at the present estimate without moving it.
  void linearise(SegmentEliminator<S>* eliminator, S damping) { linearise(eliminator, damping, nullptr, true); }
  /// Rows [theta | candidates | rhs] of some of the segments, joined as a calibration would join them, at the present
  /// estimate and without the prior on theta; all else stays as it was. They stand in theta_triangle() until the next
  /// call of anything. Returns the degrees of freedom, theta and candidates not counted.
  [[gnu::cold]] S rows_of(const bool* use, const CandidateTerms& candidates, SegmentEliminator<S>* eliminator);
  /// Robust, at the present estimate, with all priors.
  S total_cost() {
    while (!total_cost_step()) {
    }
    return total_;
  }

 private:
  void linearise(SegmentEliminator<S>* eliminator, S damping, const CandidateTerms* candidates, bool with_prior) {
    while (!linearise_step(eliminator, damping, candidates, with_prior)) {
    }
  }
  template <class Pointer>
  [[gnu::cold]] void set_up(const Pointer* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                            const MeasurementModel<S>& model);
  [[gnu::cold]] void link_up();
  void form_partitions();
  GuestLink<S> guest(int i);
  const Landmark<S>& tie(int t) const;
  S tie_prior_share(int t) const;
  [[gnu::cold]] bool total_cost_step();
  [[gnu::cold]] PackedTriangle<S> begin_linearisation(S damping, const CandidateTerms* candidates, bool with_prior);
  bool linearise_step(SegmentEliminator<S>* eliminator, S damping, const CandidateTerms* candidates = nullptr,
                      bool with_prior = true);
  [[gnu::cold]] bool step_back_step(SegmentEliminator<S>* eliminator, S damping);
  void gather_step(const SegmentEliminator<S>& eliminator, int i);
  bool refine_landmarks_step();
  void solve_theta();
  void set_chi2() {
    const S rho = theta_triangle()(theta_.columns(), theta_.columns());
    fit_.chi2 = rho * rho;
  }
  void save_states(int i) { memory_.save(i, segment_[i]->states); }
  [[gnu::cold]] void restore();
  [[gnu::cold]] bool iterate_step(SegmentEliminator<S>* eliminator, const CalibratorOptions& options);

  Near<Segment<S>> segment_[kMaxSegments];
  SegmentLink<S> link_[kMaxSegments];
  std::int32_t count_ = 0;
  Near<const ThetaPrior<S>> prior_;
  NearOrNull<const Epochs<S>> epochs_;
  Calibration<S> theta_, saved_theta_;
  MeasurementModel<S> model_;
  CalibrationFit<S> fit_;
  Partitions<S> partitions_;
  std::int32_t partition_count_ = 0;
  FitMemory<S> memory_;
  KeptEliminations<S, kKeepsEliminations> kept_;
  GlobalSystem<S> global_;
  S step_[kStateColumns * (kMaxKeyframes + 1) + kMaxGlobal + 1];

  // Where the work stands (math/resumable.h).
  Place place_ = 0, iterate_place_ = 0, inner_place_ = 0;
  std::int32_t i_ = 0, j_ = 0;
  StepPolicy<S> policy_;
  S fall_, total_;
  bool settled_ = false, running_ = false;
  S theta_step_[kMaxTheta], guest_step_[kStateColumns], last_keyframe_step_[kStateColumns];
  Near<const S> global_step_;           ///< ties and theta, in global_
  OneOf<Chain<S>, CostSteps<S>> work_;  ///< the chain makes a step, then its cost is told
  Chain<S>& chain() { return work_.template get<Chain<S>>(); }
};

}  // namespace SEGCAL_NS

#include "calibration/calibrator_problem.h"
#include "calibration/levenberg_marquardt.h"
#include "calibration/linear_system.h"
