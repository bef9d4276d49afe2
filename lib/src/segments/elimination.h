// Square-root elimination of a whole segment: the one linearisation that scoring, calibration and diagnosis share
// (docs/design.md, section 5; paper, Eq. (segment_cov_fim) and (cholesky)).
//
// Landmarks go first, each alone; velocities and biases next, along the IMU chain; what is left is the reduced system
// [poses | last keyframe | guest | theta | rhs]. Its rows from the last keyframe on are what links the segment to the
// next one; its rows from theta on are the SegmentInformation.
#pragma once

#include "math/one_of.h"
#include "math/resumable.h"
#include "segments/guest_link.h"
#include "segments/landmark_elimination.h"
#include "segments/typical_step.h"
#include "segments/velocity_bias_chain.h"
#include "segments/weights.h"

namespace SEGCAL_NS {

/// Statistics of one elimination.
struct EliminationCounts {
  std::int32_t image_points = 0, landmarks = 0, residuals = 0, unknowns = 0;
};

template <class S>
class SegmentEliminator {
 public:
  /// Linearises `segment` at its states and at theta. `damping` (square root of the Levenberg-Marquardt lambda) keeps
  /// the step of states and landmarks small; 0 for none. `candidates`: terms that get columns behind theta's.
  void eliminate(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                 const MeasurementModel<S>& model, S damping, const CandidateTerms* candidates = nullptr) {
    while (!eliminate_step(segment, guest, theta, model, damping, candidates)) {
    }
  }
  /// The same in slices (math/resumable.h): with the same arguments until it is done.
  bool eliminate_step(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                      const MeasurementModel<S>& model, S damping, const CandidateTerms* candidates = nullptr);
  /// Stands where eliminate() with the same arguments, without candidates, had ended, but for the rows of theta and
  /// below; `above_theta`: the numbers of reduced() above them, as they were then.
  void return_to(const S* above_theta, const Segment<S>& segment, const GuestLink<S>& guest,
                 const Calibration<S>& theta);
  /// Forgets work that is under way.
  void restart() { place_ = inner_place_ = 0; }

  /// What is left, and where its columns stand.
  ReducedSystem<S>& reduced() { return reduced_; }
  const ReducedLayout& layout() const { return reduced_.layout(); }
  const EliminationCounts& counts() const { return counts_; }
  S prior_share() const { return prior_share_; }

  /// Between eliminations, one X of others has the memory that landmarks and chain need (api/workspace.h): what
  /// reduced() holds stays. Another has the triangle's: what reduced() holds is lost. The next elimination ends both.
  template <class X>
  X& begin_in_block() {
    static_assert(sizeof(X) <= sizeof(Room) && alignof(X) <= alignof(Room), "the eliminator has no room for this");
    return *new (work_.template begin<Room>().bytes) X;
  }
  template <class X>
  X& in_block() {
    return *std::launder(static_cast<X*>(static_cast<void*>(work_.template get<Room>().bytes)));
  }
  template <class X>
  X& begin_in_triangle() {
    return reduced_.template begin_in_room<X>();
  }
  template <class X>
  X& in_triangle() {
    return reduced_.template in_room<X>();
  }

  /// Copies the rows of theta; for a segment without ties. Candidates are held at zero.
  void extract(SegmentInformation<S>* out);
  /// Row i of [theta | candidates | rhs] for a segment without
  /// ties, 0 <= i <= wide_theta(): all that it says about them.
  const S* wide_row(int i) {
    reduced_.global_row(i, step_);
    return step_;
  }

  // A step: [keyframes 15 K | guest 15, where joined | theta | the segment's ties].
  int last_column() const { return kStateColumns * (layout().keyframes - 1); }
  int guest_column() const { return kStateColumns * layout().keyframes; }
  int theta_column() const { return guest_column() + layout().guest_columns; }
  int tie_column() const { return theta_column() + layout().wide_theta(); }

  /// Back-substitution after eliminate() with the same arguments: entries of `step` from `known` on (last_column(),
  /// guest_column() or theta_column()) are given, the others are filled in.
  void back_substitute(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                       const MeasurementModel<S>& model, S damping, S* step, int known) {
    while (!back_substitute_step(segment, guest, theta, model, damping, step, known)) {
    }
  }
  bool back_substitute_step(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                            const MeasurementModel<S>& model, S damping, S* step, int known);
  /// Then moves the segment's states and landmarks along `step`, linearised where eliminate() was called.
  void move(Segment<S>* segment, const Calibration<S>& theta, const MeasurementModel<S>& model, S damping,
            const S* step) {
    while (!move_step(segment, theta, model, damping, step)) {
    }
  }
  bool move_step(Segment<S>* segment, const Calibration<S>& theta, const MeasurementModel<S>& model, S damping,
                 const S* step);

 private:
  void lay_out(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
               const CandidateTerms* candidates);
  void add_term(const Term& t, ReducedLayout* layout);
  bool fold_landmarks_step(const Segment<S>& segment, const Calibration<S>& theta, const MeasurementModel<S>& model,
                           S damping);
  bool fold_ties_step(const Segment<S>& segment, const Calibration<S>& theta, const MeasurementModel<S>& model);
  void hold_gauge(const State<S>& x, const MeasurementModel<S>& model);
  void damp_pose(int k, int first, S damping);
  bool run_chain_step(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                      const MeasurementModel<S>& model, S damping);
  [[gnu::cold]] void link_guest(const Segment<S>& segment, const GuestLink<S>& guest, const MeasurementModel<S>& model);
  void link_keyframes(const Segment<S>& segment, int k, const MeasurementModel<S>& model);
  void start_chain(const Segment<S>& segment, const GuestLink<S>& guest, const MeasurementModel<S>& model, int axis);
  void move_landmark(Segment<S>* segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                     S damping, const S* step);
  void spread_step(const S* step);
  void spread_linked(const S* step);

  EliminationCounts counts_;
  S prior_share_ = S(0);
  struct Linked {
    VelocityBiasChain<S> chain;
    LinkIntegration<S> link;
  };
  /// For the analysis of a triangle over theta, at the least: its eigenvectors, two triangles, some lists.
  struct Room {
    static constexpr int kNumbers = 2 * kMaxTheta * kMaxTheta + packed_size(kMaxTheta + 1) + 8 * kMaxTheta + 300;
    static constexpr std::size_t largest(std::size_t a, std::size_t b) { return a > b ? a : b; }
    alignas(8) unsigned char bytes[largest(kNumbers * sizeof(S), largest(sizeof(LandmarkBlock<S>), sizeof(Linked)))];
  };
  OneOf<LandmarkBlock<S>, Linked, Room> work_;  ///< landmarks, then the chain; nothing of them between eliminations
  LandmarkBlock<S>& landmark_block() { return work_.template get<LandmarkBlock<S>>(); }
  Linked& linked() { return work_.template get<Linked>(); }
  ReducedSystem<S> reduced_;
  ImuTermColumns<S> imu_terms_;
  Term camera_term_[kMaxEffectColumns + 1];
  int n_theta_ = 0;          // without candidates
  S step_[kReducedColumns];  // in the reduced layout
  Place place_ = 0, inner_place_ = 0;
  std::int32_t k_ = 0, j_ = 0;
  LandmarkFit<S> fit_;
};

template <class S>
bool SegmentEliminator<S>::eliminate_step(const Segment<S>& segment, const GuestLink<S>& guest,
                                          const Calibration<S>& theta, const MeasurementModel<S>& model, S damping,
                                          const CandidateTerms* candidates) {
  SEGCAL_SLICES(place_) {
    lay_out(segment, guest, theta, candidates);
    work_.template begin<LandmarkBlock<S>>();
    counts_ = EliminationCounts{};
    prior_share_ = S(0);
    SEGCAL_AWAIT(place_, fold_landmarks_step(segment, theta, model, damping));
    SEGCAL_AWAIT(place_, fold_ties_step(segment, theta, model));
    SEGCAL_PAUSE(place_);
    if (guest.holds_gauge()) hold_gauge(segment.states.x[0], model);
    SEGCAL_PAUSE(place_);
    for (k_ = 0; k_ < layout().keyframes && damping > S(0); ++k_) {
      damp_pose(k_, 0, damping);
      SEGCAL_PAUSE(place_);
      damp_pose(k_, 3, damping);
      SEGCAL_PAUSE(place_);
    }
    work_.template begin<Linked>().chain.begin(nullptr, layout(), nullptr);
    SEGCAL_AWAIT(place_, run_chain_step(segment, guest, theta, model, damping));
    SEGCAL_PAUSE(place_);
    linked().chain.finish(&reduced_);
    SEGCAL_AWAIT(place_, reduced_.fold_step());
    // Gauge, bias prior and damping are no residuals; the bias walk over a gap is.
    counts_.unknowns -= (guest.holds_gauge() ? 4 : 0) + (guest.join == Join::none ? 6 : 0);
    counts_.residuals += guest.join == Join::bias ? 6 : 0;
    counts_.residuals += 2 * counts_.image_points + 15 * linked().chain.links();
    counts_.unknowns += 3 * counts_.landmarks + kStateColumns * layout().keyframes;
  }
  SEGCAL_SLICES_END(place_);
}

template <class S>
void SegmentEliminator<S>::lay_out(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                                   const CandidateTerms* candidates) {
  ReducedLayout layout;
  layout.keyframes = segment.n_keyframes;
  layout.guest_columns = guest.join == Join::none ? 0 : kStateColumns;
  layout.sensor_cameras = theta.imu_column();
  layout.tied = guest.tied;
  imu_terms_.n = 0;
  n_theta_ = theta.columns();
  for (int i = 0; i < theta.effects.count(); ++i) add_term(theta.effects.term[i], &layout);
  for (int i = 0; candidates && i < candidates->count(); ++i) add_term(candidates->term[i], &layout);
  reduced_.begin(layout);
}

/// What does not fit any more has no column.
template <class S>
void SegmentEliminator<S>::add_term(const Term& t, ReducedLayout* layout) {
  if (layout->terms >= kMaxEffectColumns) return;
  if (t.of_imu()) {
    imu_terms_.term[imu_terms_.n++] = t;
  } else {
    camera_term_[layout->camera_terms] = t;
  }
  layout->add_term(t);
}

/// 1/m and 1/rad. The gauge: position and rotation about gravity of the first keyframe. Measurements and the priors on
/// distances from the cameras leave them exactly free; the priors of ties, which count from fixed points, do not: they
/// pull the world away from near ones, by 2 rho^3 / sigma^2 each (some 24 (1/m) at 15 cm). What is held is the position
/// of this iteration, so that the world creeps by pull / hold^2 with each: with this hold not at all, and float tells
/// it from the whitened rows (1e5 at most).
template <class S>
constexpr S kGaugeHold = S(1e5);

/// Position and rotation about gravity of the first keyframe.
template <class S>
void SegmentEliminator<S>::hold_gauge(const State<S>& x, const MeasurementModel<S>& model) {
  const S hold = kGaugeHold<S>;
  for (int i = 0; i < 3; ++i) reduced_.fold_scalar(layout().pose(0) + 3 + i, hold, S(0));
  reduced_.fold_rotation(0, x.R_GI.transpose() * (model.g / -square_root(model.g.squaredNorm())), hold);
}

/// Three of a pose's columns.
template <class S>
void SegmentEliminator<S>::damp_pose(int k, int first, S damping) {
  for (int c = first; c < first + 3; ++c) {
    reduced_.fold_scalar(layout().pose(k) + c, damping / typical_step<S>(c), S(0));
  }
}

template <class S>
void SegmentEliminator<S>::extract(SegmentInformation<S>* out) {
  const int n = n_theta_, wide = layout().wide_theta();
  out->n_theta = n;
  out->dof = counts_.residuals - counts_.unknowns;
  PackedTriangle<S> info = out->triangle();
  info.clear();
  for (int i = 0; i <= wide; ++i) {
    reduced_.global_row(i, step_);
    step_[n] = step_[wide];
    fold_rows(info, step_, 1, n + 1, 0, n + 1);
  }
}

}  // namespace SEGCAL_NS

#include "segments/elimination_chain.h"
#include "segments/elimination_landmarks.h"
#include "segments/elimination_step.h"
