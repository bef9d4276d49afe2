// Levenberg-Marquardt over the kept segments (paper, Sec. V-D; DESIGN, section 4, "Calibration").
//
// Each iteration eliminates every segment to theta, the ties and its separators, solves the small dense triangle of ties
// and theta, walks the chain back and substitutes each segment's states. Nothing grows with the number of segments but one
// row block each.
#pragma once

#include <new>

#include "calibration/chain.h"
#include "calibration/condenser.h"
#include "calibration/global_system.h"
#include "calibration/partitions.h"
#include "segments/segment_cost.h"
#include "segments/triangulation.h"
#include "segments/visible_translation.h"

namespace SEGCAL_NS {

struct CalibratorOptions {
  int max_iterations = 30;
  double converged = 4e-3;   ///< squared length of a step of theta, in sigmas: below 0.06 sigma the fit counts as converged,
  double settled = 4e-4;     ///< and goes on to 0.02 sigma as long as there are iterations left
  /// At the last iteration, where the cost is flat: corner tracks with tails make robust weights swing to and fro about the
  /// minimum. Half a sigma beside it adds 12 % to an error of one sigma; refusing the fit would leave nothing.
  double swings = 0.25;
};

/// What the fit looks like at its end.
template <class S>
struct CalibrationFit {
  bool converged = false;
  std::int32_t iterations = 0;
  std::int32_t image_points = 0;
  S start_cost = S(0), cost = S(0);   ///< robust
  S chi2 = S(0), dof = S(0);          ///< weighted squares at the end and their degrees of freedom
};

template <class S>
struct StoredFields;   // store/stored_fields.h

template <class S>
class Calibrator {
  friend struct StoredFields<S>;

 public:
  /// Sets up a problem over `segments` (pointers, in time order within each session; count <= kMaxSegments). Their
  /// states are moved by run(). The prior must stay where it is.
  void begin(Segment<S>* const* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
             const MeasurementModel<S>& model);
  void begin(Segment<S>* const* segments, int count, ThetaPrior<S>&& prior, const Calibration<S>& theta,
             const MeasurementModel<S>& model) = delete;
  /// The same to look at the segments only: they stay as they are, and so does the fit of the last calibration.
  void continue_with(Segment<S>* const* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                     const MeasurementModel<S>& model);
  /// Told by epochs too, from begin() on. They must stay as they are while a fit is under way.
  void take_epochs(const Epochs<S>* epochs) { epochs_ = epochs; }
  /// Iterates to convergence.
  void run(const CalibratorOptions& options, SegmentEliminator<S>* eliminator) {
    while (!run_step(options, eliminator)) {
    }
  }
  /// The same in slices (math/resumable.h). Between two of them the eliminator is not the caller's.
  bool run_step(const CalibratorOptions& options, SegmentEliminator<S>* eliminator);

  /// For costs of single segments, while no run is under way.
  void lend_cost_steps() { new (&work_.cost) CostSteps<S>; }
  CostSteps<S>& cost_steps() { return work_.cost; }
  /// Memory to condense a segment in, while no run is under way; the cost steps end with it.
  CondenseMemory<S> lend_condense_memory(SegmentEliminator<S>* eliminator) { return {eliminator, new (&work_.chain) Chain<S>, step_}; }

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
  /// Leaves out image points whose residual is longer than `limit` times the noise that the fit shows; earlier marks are
  /// taken back. Between runs, so that each run has one smooth cost.
  bool reject_outliers_step(S limit) {
    const S ratio = fit_.dof > S(0) ? fit_.chi2 / fit_.dof : S(1);
    const S scaled = limit * square_root(ratio > S(1) ? ratio : S(1));
    SEGCAL_SLICES(place_) {
      for (i_ = 0; i_ < count_; ++i_) {
        mark_outliers(theta_, model_, scaled, segment_[i_]);
        segment_[i_]->wide_depth_prior = !translation_shows(*segment_[i_], theta_, model_);
        SEGCAL_PAUSE(place_);
      }
      form_partitions();  // without a tie whose points are gone
    }
    SEGCAL_SLICES_END(place_);
  }
  void reject_outliers(S limit) {
    while (!reject_outliers_step(limit)) {
    }
  }
  /// The first run of a calibration takes the wide prior everywhere: which segments only turned shows when it has settled.
  void accept_all() {
    for (int i = 0; i < count_; ++i) {
      segment_[i]->wide_depth_prior = true;
      for (int o = 0; o < segment_[i]->n_observations; ++o) segment_[i]->observation[o].rejected = 0;
    }
    form_partitions();
  }
  const MeasurementModel<S>& model() const { return model_; }
  /// Eliminates everything at the present estimate without moving it.
  void linearise(SegmentEliminator<S>* eliminator, S damping) { linearise(eliminator, damping, nullptr, true); }
  /// Rows [theta | candidates | rhs] of some of the segments, joined as a calibration would join them, at the present
  /// estimate and without the prior on theta; all else stays as it was. They stand in theta_triangle() until the next call
  /// of anything. Returns the degrees of freedom, theta and candidates not counted.
  S rows_of(const bool* use, const CandidateTerms& candidates, SegmentEliminator<S>* eliminator);
  /// Robust, at the present estimate, with all priors.
  S total_cost() {
    while (!total_cost_step()) {
    }
    return total_;
  }
  /// Memory for one segment, while no calibration is under way; begin() takes it back.
  Segment<S>* lend_segment() {
    static_assert(sizeof(Segment<S>) <= sizeof(Memory), "the memory of a fit is too small to lend");
    return new (&memory_) Segment<S>;
  }

 private:
  void linearise(SegmentEliminator<S>* eliminator, S damping, const CandidateTerms* candidates, bool with_prior) {
    while (!linearise_step(eliminator, damping, candidates, with_prior)) {
    }
  }
  void set_up(Segment<S>* const* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
              const MeasurementModel<S>& model);
  void link_up();
  void form_partitions();
  GuestLink<S> guest(int i);
  const Landmark<S>& tie(int t) const;
  S tie_prior_share(int t) const;
  bool total_cost_step();
  PackedTriangle<S> begin_linearisation(S damping, const CandidateTerms* candidates, bool with_prior);
  bool linearise_step(SegmentEliminator<S>* eliminator, S damping, const CandidateTerms* candidates = nullptr, bool with_prior = true);
  bool step_back_step(SegmentEliminator<S>* eliminator, S damping);
  void gather_step(const SegmentEliminator<S>& eliminator, int i);
  bool refine_landmarks_step();
  void solve_theta();
  void set_chi2() {
    const S rho = theta_triangle()(theta_.columns(), theta_.columns());
    fit_.chi2 = rho * rho;
  }
  LeftRows<S>* left(int i) { return i > 0 ? &memory_.other[i - 1].left : nullptr; }
  SegmentStates<S>& saved(int i) { return i > 0 ? memory_.other[i - 1].states : memory_.first; }
  void save_states(int i) { new (&saved(i)) SegmentStates<S>(segment_[i]->states); }
  void restore();
  bool turned_back(const S* theta_step);
  bool iterate_step(SegmentEliminator<S>* eliminator, const CalibratorOptions& options);
  bool judge_step(S trial, const CalibratorOptions& options);

  Segment<S>* segment_[kMaxSegments];
  SegmentLink<S> link_[kMaxSegments];
  std::int32_t count_ = 0;
  const ThetaPrior<S>* prior_;
  const Epochs<S>* epochs_ = nullptr;
  Calibration<S> theta_, saved_theta_;
  MeasurementModel<S> model_;
  CalibrationFit<S> fit_;
  Partitions<S> partitions_;
  std::int32_t partition_count_ = 0;
  /// Of one segment, while a fit is under way: what came from the left until its guest's step is known, then the states that
  /// its own step moves.
  union Kept {
    Kept() {}
    LeftRows<S> left;
    SegmentStates<S> states;
  };
  /// So many that a segment fits as well, where few are kept: it is lent.
  static constexpr int others() {
    constexpr int needed = kMaxSegments > 1 ? kMaxSegments - 1 : 1;
    constexpr int lent = static_cast<int>((sizeof(Segment<S>) + sizeof(Kept) - 1) / sizeof(Kept));
    return needed > lent ? needed : lent;
  }
  /// What is only there while a fit is under way.
  struct Memory {
    SegmentStates<S> first;   ///< nobody is on its left
    Kept other[others()];
  };
  alignas(Segment<S>) Memory memory_;
  S last_step_[kMaxTheta];
  GlobalSystem<S> global_;
  S step_[kStateColumns * (kMaxKeyframes + 1) + kMaxGlobal + 1];

  // Where the work stands (math/resumable.h).
  Place place_ = 0, iterate_place_ = 0, inner_place_ = 0;
  std::int32_t i_ = 0, j_ = 0;
  S damping_, cost_, fall_, total_;
  bool settled_ = false, flat_ = false;
  S theta_step_[kMaxTheta], guest_step_[kStateColumns], last_keyframe_step_[kStateColumns];
  const S* global_step_ = nullptr;  ///< ties and theta, in global_
  /// One after the other: the chain makes a step, then its cost is told.
  union Work {
    Work() {}
    Chain<S> chain;
    CostSteps<S> cost;
  };
  Work work_;
};

template <class S>
void Calibrator<S>::begin(Segment<S>* const* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                          const MeasurementModel<S>& model) {
  set_up(segments, count, prior, theta, model);
  link_up();
}

template <class S>
void Calibrator<S>::continue_with(Segment<S>* const* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                                  const MeasurementModel<S>& model) {
  bool same = count == count_;
  for (int i = 0; i < count && same; ++i) same = segment_[i] == segments[i];
  if (same) return;
  const CalibrationFit<S> fit = fit_;
  set_up(segments, count, prior, theta, model);
  saved_theta_ = theta_;
  for (int i = 0; i < count; ++i) save_states(i);
  link_up();  // ties give landmarks other values
  restore();
  fit_ = fit;
}

template <class S>
void Calibrator<S>::set_up(Segment<S>* const* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                           const MeasurementModel<S>& model) {
  count_ = count;
  prior_ = &prior;
  epochs_ = nullptr;
  theta_ = theta;
  model_ = model;
  fit_ = CalibrationFit<S>{};
  place_ = iterate_place_ = inner_place_ = 0;
  new (&memory_) Memory;
  for (int i = 0; i < count; ++i) segment_[i] = segments[i];
}

template <class S>
void Calibrator<S>::link_up() {
  for (int i = 0; i < count_; ++i) {
    link_[i] = i > 0 ? link_after(end_of(*segment_[i - 1]), *segment_[i]) : SegmentLink<S>{};
    if (i > 0) link_[i - 1].passes_on = link_[i].join != Join::none;
  }
  form_partitions();
}

template <class S>
void Calibrator<S>::form_partitions() {
  partitions_.form(segment_, link_, count_, theta_, model_);
  partition_count_ = partitions_.count();
}

template <class S>
GuestLink<S> Calibrator<S>::guest(int i) {
  GuestLink<S> g;
  g.join = link_[i].join;
  g.gap_s = link_[i].gap_s;
  if (g.join != Join::none) {
    const Segment<S>& before = *segment_[i - 1];
    g.state = before.states.x[before.n_keyframes - 1];
    g.state.p_GI = segment_[i]->from_origin_of(before, g.state.p_GI);
  }
  g.hangs = !partitions_.is_first(i);
  partitions_.ties().of_segment(i, &g.tied);
  return g;
}

template <class S>
const Landmark<S>& Calibrator<S>::tie(int t) const {
  const int i = partitions_.ties().first_segment(t);
  return segment_[i]->states.landmark[partitions_.ties().landmark(t, i)];
}

template <class S>
bool Calibrator<S>::total_cost_step() {
  SEGCAL_SLICES(inner_place_) {
    total_ = prior_cost(*prior_, theta_);
    if (kEpochs > 0 && epochs_) total_ += epochs_->cost(theta_);
    for (int t = 0; t < partitions_.ties().count(); ++t) total_ += inverse_depth_cost(tie(t), model_.inverse_depth_sigma);
    lend_cost_steps();
    for (i_ = 0; i_ < count_; ++i_) {
      SEGCAL_AWAIT(inner_place_, work_.cost.step(*segment_[i_], guest(i_), theta_, model_));
      total_ += work_.cost.total();
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

/// Part of a tie's inverse depth's information that is prior, as LandmarkFit has it for other landmarks.
template <class S>
S Calibrator<S>::tie_prior_share(int t) const {
  S data[packed_size(kLandmarkColumns)];
  PackedTriangle<S> R(data, kLandmarkColumns);
  R.clear();
  for (int i = 0; i < count_; ++i) {
    const int j = partitions_.ties().landmark(t, i);
    if (j >= 0) fold_landmark(*segment_[i], j, theta_, model_, &R);
  }
  const S prior = S(1) / (model_.inverse_depth_sigma * model_.inverse_depth_sigma);
  return prior / (R(2, 2) * R(2, 2) + prior);
}

template <class S>
bool Calibrator<S>::linearise_step(SegmentEliminator<S>* eliminator, S damping, const CandidateTerms* candidates, bool with_prior) {
  PackedTriangle<S> G = global_.triangle();
  SEGCAL_SLICES(inner_place_) {
    G = begin_linearisation(damping, candidates, with_prior);
    for (i_ = 0; i_ < partitions_.ties().count(); ++i_) {
      fit_.dof -= S(kLandmarkColumns) - tie_prior_share(i_);
      SEGCAL_PAUSE(inner_place_);
    }
    eliminator->restart();
    for (i_ = 0; i_ < count_; ++i_) {
      segment_[i_]->turned_only = !translation_shows(*segment_[i_], theta_, model_);
      SEGCAL_PAUSE(inner_place_);
      SEGCAL_AWAIT(inner_place_, eliminator->eliminate_step(*segment_[i_], guest(i_), theta_, model_, damping, candidates));
      SEGCAL_AWAIT(inner_place_, work_.chain.add_step(eliminator, link_[i_].join != Join::none, link_[i_].passes_on,
                                                 candidates ? nullptr : left(i_), &G));
      fit_.image_points += eliminator->counts().image_points;
      fit_.dof += S(eliminator->counts().residuals - eliminator->counts().unknowns) + eliminator->prior_share();
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

/// Priors and damping of what is not any segment's, and theta's degrees of freedom.
template <class S>
PackedTriangle<S> Calibrator<S>::begin_linearisation(S damping, const CandidateTerms* candidates, bool with_prior) {
  const int ties = partitions_.ties().count();
  global_.begin(ties, theta_.columns() + (candidates ? candidates->count() : 0));
  global_.triangle().clear();
  if (with_prior) global_.clear_to_prior(*prior_, theta_);
  for (int t = 0; t < ties; ++t) global_.add_tie(t, tie(t), model_, damping);
  (new (&work_.chain) Chain<S>)->begin(global_.columns());
  const bool with_epochs = kEpochs > 0 && with_prior && epochs_ && epochs_->count() > 0;
  fit_.image_points = 0;
  fit_.dof = count_ > 0 || with_epochs ? -S(theta_.columns()) : S(0);
  if (with_epochs) {
    PackedTriangle<S> T = theta_triangle();
    epochs_->fold_into(theta_, &T);
    fit_.dof += epochs_->dof();
    fit_.image_points = epochs_->image_points();
  }
  return global_.triangle();
}

template <class S>
S Calibrator<S>::rows_of(const bool* use, const CandidateTerms& candidates, SegmentEliminator<S>* eliminator) {
  Segment<S>* all[kMaxSegments];
  bool turned_only[kMaxSegments];
  const int count = count_;
  const CalibrationFit<S> fit = fit_;
  saved_theta_ = theta_;
  for (int i = 0; i < count; ++i) save_states(i);  // ties of other partitions give landmarks other values
  count_ = 0;
  for (int i = 0; i < count; ++i) {
    all[i] = segment_[i];
    turned_only[i] = all[i]->turned_only;
    if (use[i]) segment_[count_++] = all[i];
  }
  link_up();
  linearise(eliminator, S(0), &candidates, false);
  const S dof = count_ > 0 ? fit_.dof + S(theta_.columns()) : S(0);
  for (int i = 0; i < count; ++i) {
    segment_[i] = all[i];
    all[i]->turned_only = turned_only[i];
  }
  count_ = count;
  restore();
  link_up();
  restore();
  fit_ = fit;
  return dof;
}

template <class S>
bool Calibrator<S>::step_back_step(SegmentEliminator<S>* eliminator, S damping) {
  SEGCAL_SLICES(inner_place_) {
    eliminator->restart();
    global_step_ = global_.solve_ties(theta_step_);
    for (S& s : guest_step_) s = S(0);
    for (i_ = count_ - 1; i_ >= 0; --i_) {
      // The step that the segment after this one found for our last keyframe; none hangs on it: none is known.
      for (int c = 0; c < kStateColumns; ++c) last_keyframe_step_[c] = link_[i_].passes_on ? guest_step_[c] : S(0);
      if (i_ < count_ - 1) {  // linearise_step() ended with the last one
        SEGCAL_AWAIT(inner_place_, eliminator->eliminate_step(*segment_[i_], guest(i_), theta_, model_, damping));
      }
      if (link_[i_].join != Join::none) {
        SEGCAL_AWAIT(inner_place_, work_.chain.solve_guest_step(eliminator, link_[i_].passes_on, *left(i_), last_keyframe_step_,
                                                           global_step_, guest_step_));
        SEGCAL_PAUSE(inner_place_);
      }
      gather_step(*eliminator, i_);
      SEGCAL_AWAIT(inner_place_, eliminator->back_substitute_step(*segment_[i_], guest(i_), theta_, model_, damping, step_,
                                                                  link_[i_].passes_on ? eliminator->last_column() : eliminator->guest_column()));
      save_states(i_);
      SEGCAL_AWAIT(inner_place_, eliminator->move_step(segment_[i_], theta_, model_, damping, step_));
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

/// What is known of segment i's step: its last keyframe, guest, theta and ties.
template <class S>
void Calibrator<S>::gather_step(const SegmentEliminator<S>& eliminator, int i) {
  const TiedLandmarks tied = guest(i).tied;
  for (int c = 0; c < kStateColumns; ++c) {
    step_[eliminator.last_column() + c] = last_keyframe_step_[c];
    if (link_[i].join != Join::none) step_[eliminator.guest_column() + c] = guest_step_[c];
  }
  for (int c = 0; c < theta_.columns(); ++c) step_[eliminator.theta_column() + c] = theta_step_[c];
  for (int c = 0; c < kLandmarkColumns * tied.n; ++c) {
    step_[eliminator.tie_column() + c] = global_step_[kLandmarkColumns * tied.number[c / kLandmarkColumns] + c % kLandmarkColumns];
  }
}

/// Each landmark to its best place given the new poses and theta: what is most curved in the problem, the inverse
/// distances of landmarks with little parallax, no longer limits the step (Golub and Pereyra's variable projection).
/// Ties have moved with theta: several segments see them.
template <class S>
bool Calibrator<S>::refine_landmarks_step() {
  SEGCAL_SLICES(inner_place_) {
    for (i_ = 0; i_ < count_; ++i_) {
      for (j_ = 0; j_ < segment_[i_]->n_landmarks; ++j_) {
        if (guest(i_).tied.place_of(j_) >= 0) continue;
        refine_landmark(*segment_[i_], j_, theta_, model_, 2, &segment_[i_]->states.landmark[j_]);
        SEGCAL_PAUSE(inner_place_);
      }
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

template <class S>
void Calibrator<S>::restore() {
  theta_ = saved_theta_;
  for (int i = 0; i < count_; ++i) segment_[i]->states = saved(i);
}

/// True if this step goes against the last one (by more than 120 deg): undamped steps swing about the minimum along weak
/// directions, such as place against inverse distance when there is hardly any parallax. Keeps the step for the next time.
template <class S>
bool Calibrator<S>::turned_back(const S* theta_step) {
  S along = S(0), now = S(0), before = S(0);
  for (int i = 0; i < theta_.columns(); ++i) {
    const S a = theta_step[i] / prior_->sigma[i], b = last_step_[i];
    along += a * b;
    now += a * a;
    before += b * b;
    last_step_[i] = a;
  }
  return along < S(0) && along * along > S(0.25) * now * before;
}

/// Step of theta from the triangle, which has just been made.
template <class S>
void Calibrator<S>::solve_theta() {
  const int n = theta_.columns();
  const PackedTriangle<S> T = theta_triangle();
  fall_ = S(0);
  for (int i = 0; i < n; ++i) {
    theta_step_[i] = T(i, n);
    fall_ += T(i, n) * T(i, n);
  }
  back_substitute(T, n, theta_step_);
}

/// One step: kept if the cost falls, taken back and damped more if not. When it is done, settled_ says whether nothing is
/// left to gain.
template <class S>
bool Calibrator<S>::iterate_step(SegmentEliminator<S>* eliminator, const CalibratorOptions& options) {
  SEGCAL_SLICES(iterate_place_) {
    SEGCAL_AWAIT(iterate_place_, linearise_step(eliminator, damping_));
    solve_theta();
    saved_theta_ = theta_;
    SEGCAL_PAUSE(iterate_place_);
    SEGCAL_AWAIT(iterate_place_, step_back_step(eliminator, damping_));
    add_step(&theta_, theta_step_);
    SEGCAL_AWAIT(iterate_place_, refine_landmarks_step());
    SEGCAL_AWAIT(iterate_place_, total_cost_step());
    settled_ = judge_step(total_, options);
  }
  SEGCAL_SLICES_END(iterate_place_);
}

template <class S>
bool Calibrator<S>::judge_step(S trial, const CalibratorOptions& options) {
  // Near the minimum the difference drowns in the rounding of the sum.
  const S rounding = (std::is_same_v<S, float> ? S(2e-6) : S(1e-13)) * cost_;
  if (!(trial <= cost_ + rounding)) {
    restore();
    damping_ = damping_ > S(0) ? damping_ * S(4) : S(0.05);
    // A step that should gain less than this, and gains nothing, has met the rounding: damping it further cannot help.
    const bool done = fall_ < S(options.converged) || damping_ > S(1e4);
    if (done) fit_.converged = true;
    return done;
  }
  flat_ = cost_ - trial <= S(1e-3) * cost_;
  if (flat_ && fall_ < S(options.converged)) fit_.converged = true;
  cost_ = trial;
  if (turned_back(theta_step_)) {
    damping_ = damping_ > S(0) ? damping_ * S(2) : S(0.05);
  } else {
    damping_ = damping_ < S(0.05) ? S(0) : damping_ * S(0.2);
  }
  return flat_ && fall_ < S(options.settled);
}

template <class S>
bool Calibrator<S>::run_step(const CalibratorOptions& options, SegmentEliminator<S>* eliminator) {
  SEGCAL_SLICES(place_) {
    damping_ = S(0);
    SEGCAL_AWAIT(place_, total_cost_step());
    cost_ = fit_.start_cost = total_;
    fit_.converged = settled_ = flat_ = false;
    for (S& s : last_step_) s = S(0);
    for (fit_.iterations = 0; fit_.iterations < options.max_iterations && !settled_; ++fit_.iterations) {
      SEGCAL_AWAIT(place_, iterate_step(eliminator, options));
    }
    fit_.cost = cost_;
    fit_.converged = fit_.converged || (flat_ && fall_ < S(options.swings));
    SEGCAL_AWAIT(place_, linearise_step(eliminator, S(0)));
    set_chi2();
  }
  SEGCAL_SLICES_END(place_);
}

}  // namespace SEGCAL_NS
