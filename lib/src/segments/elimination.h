// Square-root elimination of a whole segment: the one linearisation that scoring, calibration and diagnosis share
// (DESIGN, section 4; paper, Eq. (segment_cov_fim) and (cholesky)).
//
// Landmarks go first, each alone; velocities and biases next, along the IMU chain; what is left is the reduced system
// [poses | last keyframe | guest | theta | rhs]. Its rows from the last keyframe on are what links the segment to its
// neighbours; its rows from theta on are the SegmentInformation.
#pragma once

#include <new>

#include "math/resumable.h"
#include "segments/landmark_elimination.h"
#include "segments/velocity_bias_chain.h"
#include "segments/weights.h"

namespace SEGCAL_NS {

/// How a segment hangs on the one before it in time.
enum class Join : std::int32_t {
  none,  ///< starts a partition: gauge and bias prior on its first keyframe
  imu,   ///< direct neighbour: the raw samples between the two are integrated
  bias   ///< gap: only the bias random walk links them
};

template <class S>
struct GuestLink {
  Join join = Join::none;
  State<S> state;      ///< the previous segment's last keyframe
  S gap_s = S(0);      ///< s from there to the first keyframe (Join::bias)
  bool hangs = false;  ///< position and rotation about gravity come from ties: no gauge is held (calibration/partitions.h)
  TiedLandmarks tied;

  bool holds_gauge() const { return join != Join::imu && !hangs; }
};

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
  /// Forgets work that is under way.
  void restart() {
    place_ = inner_place_ = 0;
  }

  /// What is left, and where its columns stand.
  ReducedSystem<S>& reduced() { return reduced_; }
  const ReducedLayout& layout() const { return reduced_.layout(); }
  const EliminationCounts& counts() const { return counts_; }
  S prior_share() const { return prior_share_; }

  /// Memory of kLentBytes, between eliminations: what reduced() holds stays.
  void* lend() { return &work_; }

  /// Copies the rows of theta; for a segment without ties. Candidates are held at zero.
  void extract(SegmentInformation<S>* out);
  /// Row i of [theta | candidates | rhs] for a segment without ties, 0 <= i <= wide_theta(): all that it says about them.
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
  void move(Segment<S>* segment, const Calibration<S>& theta, const MeasurementModel<S>& model, S damping, const S* step) {
    while (!move_step(segment, theta, model, damping, step)) {
    }
  }
  bool move_step(Segment<S>* segment, const Calibration<S>& theta, const MeasurementModel<S>& model, S damping, const S* step);

 private:
  void lay_out(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta, const CandidateTerms* candidates);
  void add_term(const Term& t, ReducedLayout* layout);
  bool fold_landmarks_step(const Segment<S>& segment, const Calibration<S>& theta, const MeasurementModel<S>& model, S damping);
  bool fold_ties_step(const Segment<S>& segment, const Calibration<S>& theta, const MeasurementModel<S>& model);
  void hold_gauge(const State<S>& x, const MeasurementModel<S>& model);
  void damp_pose(int k, int first, S damping);
  bool run_chain_step(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                      const MeasurementModel<S>& model, S damping);
  void link_guest(const Segment<S>& segment, const GuestLink<S>& guest, const MeasurementModel<S>& model);
  void link_keyframes(const Segment<S>& segment, int k, const MeasurementModel<S>& model);
  void start_chain(const Segment<S>& segment, const GuestLink<S>& guest, const MeasurementModel<S>& model, int axis);
  void move_landmark(Segment<S>* segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model, S damping, const S* step);
  void spread_step(const S* step);
  void spread_linked(const S* step);

  EliminationCounts counts_;
  S prior_share_ = S(0);
  struct Linked {
    VelocityBiasChain<S> chain;
    LinkIntegration<S> link;
  };
  /// One after the other: landmarks, then the chain; lent between eliminations.
  union Work {
    Work() {}
    LandmarkBlock<S> landmark;
    Linked linked;
  };
  alignas(8) Work work_;

 public:
  static constexpr std::size_t kLentBytes = sizeof(Work);

 private:
  ReducedSystem<S> reduced_;
  ImuTermColumns<S> imu_terms_;
  Term camera_term_[kMaxEffectColumns + 1];
  int n_theta_ = 0;          // without candidates
  S step_[kReducedColumns];  // in the reduced layout
  Place place_ = 0, inner_place_ = 0;
  std::int32_t k_ = 0, j_ = 0;
  LandmarkFit<S> fit_;
};

/// Typical sizes of a step: damping is measured against them. rad, m, m/s, m/s^2, rad/s.
template <class S>
S typical_step(int state_column) {
  constexpr double size[5] = {0.01, 0.02, 0.05, 0.05, 0.005};
  return S(size[state_column / 3]);
}
/// The same for a landmark's direction and inverse distance (1/m).
template <class S>
constexpr S kTypicalLandmarkStep = S(0.02);

template <class S>
bool SegmentEliminator<S>::eliminate_step(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                                          const MeasurementModel<S>& model, S damping, const CandidateTerms* candidates) {
  SEGCAL_SLICES(place_) {
    lay_out(segment, guest, theta, candidates);
    new (&work_.landmark) LandmarkBlock<S>;
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
    (new (&work_.linked) Linked)->chain.begin(nullptr, layout(), nullptr);
    SEGCAL_AWAIT(place_, run_chain_step(segment, guest, theta, model, damping));
    SEGCAL_PAUSE(place_);
    work_.linked.chain.finish(&reduced_);
    SEGCAL_AWAIT(place_, reduced_.fold_step());
    // Gauge, bias prior and damping are no residuals; the bias walk over a gap is.
    counts_.unknowns -= (guest.holds_gauge() ? 4 : 0) + (guest.join == Join::none ? 6 : 0);
    counts_.residuals += guest.join == Join::bias ? 6 : 0;
    counts_.residuals += 2 * counts_.image_points + 15 * work_.linked.chain.links();
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

template <class S>
bool SegmentEliminator<S>::fold_landmarks_step(const Segment<S>& segment, const Calibration<S>& theta,
                                               const MeasurementModel<S>& model, S damping) {
  const S landmark_damping = damping / kTypicalLandmarkStep<S>;
  SEGCAL_SLICES(inner_place_) {
    // Those that end first go first: the triangle fills up to the last keyframe seen so far, and no further.
    for (k_ = 0; k_ < segment.n_keyframes; ++k_) {
      for (j_ = 0; j_ < segment.n_landmarks; ++j_) {
        if (segment.last_keyframe(j_) != k_ || layout().tied.place_of(j_) >= 0) continue;
        fit_ = work_.landmark.build(segment, j_, theta, model, layout(), camera_term_, landmark_damping);
        if (fit_.used < 2) continue;
        work_.landmark.eliminate(&fit_);
        reduced_.begin_visual(work_.landmark.rest(), fit_.rows - kLandmarkColumns, work_.landmark.stride(), fit_.first_keyframe,
                              fit_.last_keyframe, false);
        SEGCAL_PAUSE(inner_place_);
        SEGCAL_AWAIT(inner_place_, reduced_.fold_step());
        counts_.image_points += fit_.used;
        ++counts_.landmarks;
        prior_share_ += fit_.prior_share;
        SEGCAL_PAUSE(inner_place_);
      }
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

/// After the other landmarks, whose rows need not go through the ties' columns then. A tie's prior and damping are not the
/// segment's: they count once for all (calibrator.h).
template <class S>
bool SegmentEliminator<S>::fold_ties_step(const Segment<S>& segment, const Calibration<S>& theta,
                                          const MeasurementModel<S>& model) {
  SEGCAL_SLICES(inner_place_) {
    for (j_ = 0; j_ < layout().tied.n; ++j_) {
      fit_ = work_.landmark.build_tied(segment, j_, theta, model, layout(), camera_term_);
      if (fit_.used == 0) continue;
      reduced_.begin_visual(work_.landmark.tied_rows(), fit_.rows, work_.landmark.stride(), fit_.first_keyframe, fit_.last_keyframe, true);
      SEGCAL_PAUSE(inner_place_);
      SEGCAL_AWAIT(inner_place_, reduced_.fold_step());
      counts_.image_points += fit_.used;
      SEGCAL_PAUSE(inner_place_);
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

/// The gauge: position and rotation about gravity of the first keyframe. They are exactly free, so any weight holds
/// them; this one is well inside the range of float.
template <class S>
void SegmentEliminator<S>::hold_gauge(const State<S>& x, const MeasurementModel<S>& model) {
  const S hold = S(1e3);
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

/// Everything that touches velocities and biases, in time order; to eliminate them, or to solve for them.
template <class S>
bool SegmentEliminator<S>::run_chain_step(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                                          const MeasurementModel<S>& model, S damping) {
  SEGCAL_SLICES(inner_place_) {
    if (guest.join == Join::imu) {
      SEGCAL_AWAIT(inner_place_, work_.linked.link.step(segment, 0, theta, guest.state.b_a, guest.state.b_g, model.imu, &imu_terms_));
      SEGCAL_PAUSE(inner_place_);
    }
    if (guest.join != Join::none) {
      link_guest(segment, guest, model);
      SEGCAL_PAUSE(inner_place_);
      SEGCAL_AWAIT(inner_place_, work_.linked.chain.hand_over_step(&reduced_));
      SEGCAL_PAUSE(inner_place_);
    }
    for (j_ = 0; j_ < 3; ++j_) {
      start_chain(segment, guest, model, j_);
      SEGCAL_PAUSE(inner_place_);
    }
    for (k_ = 0; k_ < segment.n_keyframes; ++k_) {
      for (j_ = kPoseColumns; damping > S(0) && j_ < kStateColumns; ++j_) {
        work_.linked.chain.add_scalar(j_ - kPoseColumns, damping / typical_step<S>(j_), S(0), &reduced_);
        SEGCAL_PAUSE(inner_place_);
      }
      if (k_ + 1 == segment.n_keyframes) break;
      SEGCAL_AWAIT(inner_place_, work_.linked.link.step(segment, k_ + 1, theta, segment.states.x[k_].b_a, segment.states.x[k_].b_g, model.imu, &imu_terms_));
      SEGCAL_PAUSE(inner_place_);
      link_keyframes(segment, k_, model);
      SEGCAL_PAUSE(inner_place_);
      work_.linked.chain.finish_current();
      SEGCAL_PAUSE(inner_place_);
      work_.linked.chain.move_on();
      SEGCAL_PAUSE(inner_place_);
      SEGCAL_AWAIT(inner_place_, work_.linked.chain.hand_over_step(&reduced_));
      SEGCAL_PAUSE(inner_place_);
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

template <class S>
void SegmentEliminator<S>::link_keyframes(const Segment<S>& segment, int k, const MeasurementModel<S>& model) {
  const State<S>* x = segment.states.x;
  const ImuIntegral<S>& I = work_.linked.link.result();
  ImuRows<S>& rows = work_.linked.chain.lend_rows();
  link_rows(I, x[k], x[k + 1], x[k], x[k + 1], model.g, &rows);
  link_term_columns(rows, &imu_terms_);
  whiten(I, model.imu, &rows, &imu_terms_);
  work_.linked.chain.begin_link(rows, imu_terms_, &reduced_);
}

/// The link, integrated already, or the walk from the guest to the first keyframe.
template <class S>
void SegmentEliminator<S>::link_guest(const Segment<S>& segment, const GuestLink<S>& guest, const MeasurementModel<S>& model) {
  const State<S>& x = segment.states.x[0];
  if (guest.join == Join::imu) {
    const ImuIntegral<S>& I = work_.linked.link.result();
    ImuRows<S>& rows = work_.linked.chain.lend_rows();
    link_rows(I, guest.state, x, guest.state, x, model.g, &rows);
    link_term_columns(rows, &imu_terms_);
    if (whiten(I, model.imu, &rows, &imu_terms_)) work_.linked.chain.add_guest_link(rows, imu_terms_, &reduced_);
  } else {
    const S root = square_root(guest.gap_s);
    work_.linked.chain.add_bias_link(x.b_a - guest.state.b_a, x.b_g - guest.state.b_g, S(1) / (model.imu.accel_walk * root),
                         S(1) / (model.imu.gyro_walk * root), &reduced_);
  }
}

/// Priors on one axis of the first keyframe's velocity and, without a guest, biases.
template <class S>
void SegmentEliminator<S>::start_chain(const Segment<S>& segment, const GuestLink<S>& guest, const MeasurementModel<S>& model,
                                       int axis) {
  const State<S>& x = segment.states.x[0];
  work_.linked.chain.add_scalar(axis, S(1) / model.velocity_sigma, -x.v_GI(axis) / model.velocity_sigma, &reduced_);
  if (guest.join != Join::none) return;
  work_.linked.chain.add_scalar(3 + axis, S(1) / model.bias_a_sigma, -x.b_a(axis) / model.bias_a_sigma, &reduced_);
  work_.linked.chain.add_scalar(6 + axis, S(1) / model.bias_g_sigma, -x.b_g(axis) / model.bias_g_sigma, &reduced_);
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

/// Puts a step into the reduced layout: poses, last keyframe, guest, theta.
template <class S>
void SegmentEliminator<S>::spread_step(const S* step) {
  const ReducedLayout& at = layout();
  for (int c = 0; c < at.last(); ++c) step_[c] = step[kStateColumns * (c / kPoseColumns) + c % kPoseColumns];
  spread_linked(step);
}

/// Last keyframe, guest, theta and ties of a step.
template <class S>
void SegmentEliminator<S>::spread_linked(const S* step) {
  const ReducedLayout& at = layout();
  for (int c = at.last(); c < at.theta(); ++c) step_[c] = step[last_column() + c - at.last()];
  const S* theta = step + theta_column();
  for (int c = 0; c < at.wide_theta(); ++c) step_[at.column_of(c)] = theta[c];
  for (int c = 0; c < kLandmarkColumns * at.tied.n; ++c) step_[at.tie(0) + c] = step[tie_column() + c];
}

template <class S>
bool SegmentEliminator<S>::back_substitute_step(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                                                const MeasurementModel<S>& model, S damping, S* step, int known) {
  const ReducedLayout& at = layout();
  SEGCAL_SLICES(place_) {
    spread_linked(step);
    reduced_.back_substitute(step_, at.last() + known - last_column());
    for (int c = 0; c < at.last(); ++c) step[kStateColumns * (c / kPoseColumns) + c % kPoseColumns] = step_[c];
    for (int c = 0; c < kStateColumns; ++c) step[last_column() + c] = step_[at.last() + c];
    (new (&work_.linked) Linked)->chain.begin(step_, at, reduced_.scratch());  // the triangle has told what it knows
    SEGCAL_PAUSE(place_);
    SEGCAL_AWAIT(place_, run_chain_step(segment, guest, theta, model, damping));
    work_.linked.chain.back_substitute(step + kPoseColumns, kStateColumns);
  }
  SEGCAL_SLICES_END(place_);
}

template <class S>
bool SegmentEliminator<S>::move_step(Segment<S>* segment, const Calibration<S>& theta, const MeasurementModel<S>& model,
                                     S damping, const S* step) {
  SEGCAL_SLICES(place_) {
    spread_step(step);
    SEGCAL_PAUSE(place_);
    for (j_ = 0; j_ < segment->n_landmarks; ++j_) {
      move_landmark(segment, j_, theta, model, damping, step);
      SEGCAL_PAUSE(place_);
    }
    for (int k = 0; k < layout().keyframes; ++k) segment->states.x[k].add(step + kStateColumns * k);
  }
  SEGCAL_SLICES_END(place_);
}

template <class S>
void SegmentEliminator<S>::move_landmark(Segment<S>* segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                                         S damping, const S* step) {
  const int tie = layout().tied.place_of(j);
  if (tie >= 0) {
    // Every segment has a copy of its own, moved by the same step: they stay equal bit by bit.
    add_step(&segment->states.landmark[j], step + tie_column() + kLandmarkColumns * tie);
    return;
  }
  LandmarkFit<S> fit = work_.landmark.build(*segment, j, theta, model, layout(), camera_term_, damping / kTypicalLandmarkStep<S>);
  if (fit.used < 2) return;
  work_.landmark.eliminate(&fit);
  S landmark_step[kLandmarkColumns];
  work_.landmark.solve(step_, landmark_step);
  add_step(&segment->states.landmark[j], landmark_step);
}

}  // namespace SEGCAL_NS
