// Condenses segments, one after the other as they end, into an epoch (epoch.h): theta's rows with states and landmarks
// eliminated, linked to the segment before as a calibration would link them (chain.h).
//
// Of the segment before, 15 rows over [its last keyframe | theta | rhs] are kept and nothing else. With them a segment
// is settled at theta_0 (Gauss-Newton steps of its states, its landmarks and that keyframe; theta is held), its far
// corners are left out, and it is eliminated a last time: its rows that touch theta only go to the epoch, and those of
// its own last keyframe are what the next segment will hang on. Where the chain breaks, those rows are dropped, and
// with them the keyframe is eliminated.
#pragma once

#include "calibration/chain.h"
#include "calibration/epoch.h"
#include "calibration/partitions.h"
#include "segments/segment_cost.h"
#include "segments/triangulation.h"

namespace SEGCAL_NS {

/// What is lent while a segment is condensed.
template <class S>
struct CondenseMemory {
  Near<SegmentEliminator<S>> eliminator;
  Near<Chain<S>> chain;
  Near<S> step;  ///< kStateColumns (kMaxKeyframes + 1) + kMaxTheta numbers
};

/// Above this chi2/dof a segment is not condensed: the model does not hold for it.
constexpr double kMostCondensedMisfit = 4;
/// Corners farther off than this, in sigmas, are left out, as in a calibration.
constexpr double kFarCorner = 5;
/// The sine of half the angle (3 deg) by which the states of odometry and chain may have turned against each other.
/// What is linearised beyond that would not hold.
constexpr double kMostTurned = 0.026;

template <class S>
class Condenser {
 public:
  /// The next segment hangs on nothing.
  void break_chain() { chained_ = condensed_ = false; }
  void restart() { place_ = inner_ = 0; }

  /// Moves the segment's states and overwrites its information. `again`: the same segment once more, from where it is.
  /// In slices; true when it is done, and condensed() tells.
  [[gnu::cold]] bool step(Segment<S>* segment, const MeasurementModel<S>& model, const CondenseMemory<S>& m,
                          const Epoch<S>* epoch, bool again = false) {
    SEGCAL_SLICES(place_) {
      if (!again) begin(*segment);
      SEGCAL_AWAIT(place_, settle_step(segment, epoch->theta, model, m));
      mark_outliers(epoch->theta, model, S(kFarCorner), segment);
      SEGCAL_PAUSE(place_);
      SEGCAL_AWAIT(place_, settle_step(segment, epoch->theta, model, m));
      SEGCAL_AWAIT(place_, m.eliminator->eliminate_step(*segment, guest_, epoch->theta, model, S(0)));
      begin_chain(m, epoch->columns());
      segment->information.n_theta = epoch->columns();
      rows_of(segment).clear();
      SEGCAL_AWAIT(place_, take_rows_step(segment, m));
      judge(segment, m);
    }
    SEGCAL_SLICES_END(place_);
  }
  /// The segment's rows can go into the epoch: take() puts them there, and break_chain() forgets them.
  bool condensed() const { return condensed_; }

  /// After step(), with the same arguments; `pull`: the segment's, on what is known with it.
  [[gnu::cold]] void take(Segment<S>* segment, const CondenseMemory<S>& m, const Pull<S>& pull, Epoch<S>* epoch) {
    epoch->add(rows_of(segment), dof_, pull, segment->session, segment->serial);
    if (epoch->image_points < 1000000000) epoch->image_points += m.eliminator->counts().image_points;
    m.chain->hand_on(&left_);
    end_ = end_of(*segment);
    last_ = segment->states.x[segment->n_keyframes - 1];
    // Position is gauge: the chain goes on in the odometry's frame, so that the next segment begins near it. A turn is
    // gauge as well, but the rows on the left would turn with it.
    for (int i = 0; i < 3; ++i) place_of_last_[i] = odometry_place_[i];
    chained_ = so3_log<S>(odometry_.R_GI.transpose() * last_.R_GI).squaredNorm() < S(4 * kMostTurned * kMostTurned);
  }

 private:
  bool joined() const { return guest_.join != Join::none; }
  PackedTriangle<S> rows_of(Segment<S>* segment) { return segment->information.triangle(); }

  [[gnu::cold]] void begin(const Segment<S>& s) {
    condensed_ = false;
    guest_ = GuestLink<S>{};
    odometry_ = s.states.x[s.n_keyframes - 1];
    for (int i = 0; i < 3; ++i) odometry_place_[i] = s.origin[i] + static_cast<double>(odometry_.p_GI(i));
    if (!chained_) return;
    const SegmentLink<S> link = link_after(end_, s);
    guest_.join = link.join;
    guest_.gap_s = link.gap_s;
    guest_.state = last_;
    for (int i = 0; i < 3; ++i) guest_.state.p_GI(i) = static_cast<S>(place_of_last_[i] - s.origin[i]);
  }

  void begin_chain(const CondenseMemory<S>& m, int n_theta) {
    m.chain->begin(n_theta);
    if (joined()) m.chain->go_on(left_);
  }
  bool take_rows_step(Segment<S>* segment, const CondenseMemory<S>& m) {
    PackedTriangle<S> rows = rows_of(segment);
    return m.chain->add_step(m.eliminator, joined(), true, nullptr, &rows);
  }

  /// One step of the states, with theta held; then each landmark to its best place.
  [[gnu::cold]] bool settle_step(Segment<S>* segment, const Calibration<S>& theta, const MeasurementModel<S>& model,
                                 const CondenseMemory<S>& m) {
    const int n = theta.columns();
    S* step = m.step;
    SEGCAL_SLICES(inner_) {
      SEGCAL_AWAIT(inner_, m.eliminator->eliminate_step(*segment, guest_, theta, model, S(0)));
      for (int i = 0; i < kStateColumns * (kMaxKeyframes + 1) + kMaxTheta; ++i) step[i] = S(0);
      if (joined()) {
        m.chain->begin(n);
        SEGCAL_AWAIT(inner_, m.chain->solve_guest_step(m.eliminator, false, left_, step + m.eliminator->last_column(),
                                                       step + m.eliminator->theta_column(),
                                                       step + m.eliminator->guest_column()));
      }
      SEGCAL_AWAIT(inner_, m.eliminator->back_substitute_step(
                               *segment, guest_, theta, model, S(0), step,
                               joined() ? m.eliminator->guest_column() : m.eliminator->theta_column()));
      SEGCAL_AWAIT(inner_, m.eliminator->move_step(segment, theta, model, S(0), step));
      if (joined()) move_guest(step + m.eliminator->guest_column(), n);
      for (j_ = 0; j_ < segment->n_landmarks; ++j_) {
        refine_landmark(*segment, j_, theta, model, 2, &segment->states.landmark[j_]);
        SEGCAL_PAUSE(inner_);
      }
    }
    SEGCAL_SLICES_END(inner_);
  }

  /// What the left says is linear: moving the keyframe moves its right-hand side.
  void move_guest(const S* step, int n) {
    guest_.state.add(step);
    S* r = left_.data;
    for (int i = 0; i < kStateColumns; ++i) {
      const int columns = kStateColumns - i;
      for (int c = 0; c < columns; ++c) r[columns + n] -= r[c] * step[i + c];
      r += columns + n + 1;
    }
  }

  void judge(Segment<S>* segment, const CondenseMemory<S>& m) {
    const PackedTriangle<S> rows = rows_of(segment);
    const EliminationCounts& counts = m.eliminator->counts();
    const int n = rows.columns() - 1;
    dof_ = S(counts.residuals - counts.unknowns) + m.eliminator->prior_share();
    condensed_ = dof_ > S(0) && rows(n, n) * rows(n, n) < S(kMostCondensedMisfit) * dof_;
    chained_ = false;
  }

  Place place_ = 0, inner_ = 0;
  std::int32_t j_ = 0;
  S dof_ = S(0);  ///< of the segment, theta not counted
  bool chained_ = false, condensed_ = false;
  GuestLink<S> guest_;
  State<S> odometry_;                                                    ///< last keyframe as the odometry had it
  double odometry_place_[3] = {0, 0, 0}, place_of_last_[3] = {0, 0, 0};  ///< m, in the odometry's frame
  SegmentEnd end_;
  State<S> last_;     ///< last keyframe of the segment before, settled
  LeftRows<S> left_;  ///< what is known of it
};

/// Of a build without epochs.
struct NoCondenser {
  void break_chain() {}
  void restart() {}
};

}  // namespace SEGCAL_NS
