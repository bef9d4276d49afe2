// Levenberg-Marquardt over the kept segments (paper, Sec. V-D; DESIGN, section 4, "Calibration").
//
// Each iteration eliminates every segment to theta and its separators, solves the small dense triangle of theta, walks
// the chain back and substitutes each segment's states. Nothing grows with the number of segments but one row block each.
#pragma once

#include "calibration/chain.h"
#include "calibration/prior.h"
#include "segments/segment_cost.h"
#include "segments/triangulation.h"
#include "segments/visible_translation.h"

namespace SEGCAL_NS {

constexpr int kMaxSegments = SEGCAL_MAX_SEGMENTS;

struct CalibratorOptions {
  int max_iterations = 20;
  double converged = 4e-3;   ///< squared length of theta's last step in sigmas: 0.06 sigma over all of theta
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

/// A segment's place among its neighbours.
template <class S>
struct SegmentLink {
  Join join = Join::none;
  bool passes_on = false;   ///< the next segment hangs on this one
  S gap_s = S(0);
};

template <class S>
class Calibrator {
 public:
  /// Sets up a problem over `segments` (pointers, in time order within each session; count <= kMaxSegments). Their
  /// states are moved by run().
  void begin(Segment<S>* const* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
             const MeasurementModel<S>& model);
  /// Iterates to convergence.
  void run(const CalibratorOptions& options, SegmentEliminator<S>* eliminator);

  const Calibration<S>& theta() const { return theta_; }
  const CalibrationFit<S>& fit() const { return fit_; }
  /// Triangle over [theta | rhs] at the last linearisation, prior included: Sigma_theta = (R'R)^-1.
  PackedTriangle<S> theta_triangle() { return PackedTriangle<S>(theta_data_, theta_.columns() + 1); }
  const SegmentLink<S>& link(int i) const { return link_[i]; }
  /// Stretches that no IMU link joins: one gauge is held in each.
  int partitions() const {
    int n = 0;
    for (int i = 0; i < count_; ++i) n += link_[i].join == Join::imu ? 0 : 1;
    return n;
  }
  /// Leaves out image points whose residual is longer than `limit` times the noise that the fit shows; earlier marks are
  /// taken back. Between runs, so that each run has one smooth cost.
  void reject_outliers(S limit) {
    const S ratio = fit_.dof > S(0) ? fit_.chi2 / fit_.dof : S(1);
    const S scaled = limit * square_root(ratio > S(1) ? ratio : S(1));
    for (int i = 0; i < count_; ++i) mark_outliers(theta_, model_, scaled, segment_[i]);
  }
  void accept_all() {
    for (int i = 0; i < count_; ++i) {
      for (int o = 0; o < segment_[i]->n_observations; ++o) segment_[i]->observation[o].rejected = 0;
    }
  }
  const MeasurementModel<S>& model() const { return model_; }
  /// Eliminates everything at the present estimate without moving it.
  void linearise(SegmentEliminator<S>* eliminator, S damping);

 private:
  GuestLink<S> guest(int i) const;
  S total_cost() const;
  void step_back(SegmentEliminator<S>* eliminator, S damping, const S* theta_step);
  void refine_landmarks();
  void save();
  void restore();
  bool turned_back(const S* theta_step);
  bool iterate(SegmentEliminator<S>* eliminator, S* damping, S* cost, const CalibratorOptions& options);

  Segment<S>* segment_[kMaxSegments];
  SegmentLink<S> link_[kMaxSegments];
  std::int32_t count_ = 0;
  ThetaPrior<S> prior_;
  Calibration<S> theta_, saved_theta_;
  MeasurementModel<S> model_;
  CalibrationFit<S> fit_;
  Chain<S> chain_;
  GuestRows<S> kept_[kMaxSegments];
  SegmentStates<S> saved_[kMaxSegments];
  S last_step_[kMaxTheta];
  S theta_data_[packed_size(kMaxTheta + 1)];
  S step_[kStateColumns * (kMaxKeyframes + 1) + kMaxTheta + 1];
};

/// How segment b hangs on a, the segment before it in the database.
template <class S>
SegmentLink<S> link_between(const Segment<S>& a, const Segment<S>& b) {
  SegmentLink<S> link;
  if (a.session != b.session) return link;
  link.join = b.serial == a.serial + 1 && b.lead_us > 0 ? Join::imu : Join::bias;
  const std::int64_t end = a.t0_ns + std::int64_t(a.t_us[a.n_keyframes - 1]) * 1000;
  link.gap_s = S(b.t0_ns - end) * S(1e-9);
  return link;
}

template <class S>
void Calibrator<S>::begin(Segment<S>* const* segments, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                          const MeasurementModel<S>& model) {
  count_ = count;
  prior_ = prior;
  theta_ = theta;
  model_ = model;
  fit_ = CalibrationFit<S>{};
  for (int i = 0; i < count; ++i) {
    segment_[i] = segments[i];
    link_[i] = i > 0 ? link_between(*segments[i - 1], *segments[i]) : SegmentLink<S>{};
    if (i > 0) link_[i - 1].passes_on = link_[i].join != Join::none;
  }
}

template <class S>
GuestLink<S> Calibrator<S>::guest(int i) const {
  GuestLink<S> g;
  g.join = link_[i].join;
  g.gap_s = link_[i].gap_s;
  if (g.join != Join::none) g.state = segment_[i - 1]->states.x[segment_[i - 1]->n_keyframes - 1];
  return g;
}

template <class S>
S Calibrator<S>::total_cost() const {
  S total = prior_cost(prior_, theta_);
  for (int i = 0; i < count_; ++i) total += segment_cost(*segment_[i], guest(i), theta_, model_);
  return total;
}

template <class S>
void Calibrator<S>::linearise(SegmentEliminator<S>* eliminator, S damping) {
  PackedTriangle<S> T = theta_triangle();
  write_prior(prior_, theta_, &T);
  chain_.begin(theta_.columns());
  fit_.image_points = 0;
  fit_.dof = count_ > 0 ? -S(theta_.columns()) : S(0);
  for (int i = 0; i < count_; ++i) {
    segment_[i]->turned_only = !translation_shows(*segment_[i], theta_, model_);
    eliminator->eliminate(*segment_[i], guest(i), theta_, model_, damping);
    chain_.add(eliminator, link_[i].join != Join::none, link_[i].passes_on, &kept_[i], &T);
    fit_.image_points += eliminator->counts().image_points;
    fit_.dof += S(eliminator->counts().residuals - eliminator->counts().unknowns) + eliminator->prior_share();
  }
}

template <class S>
void Calibrator<S>::step_back(SegmentEliminator<S>* eliminator, S damping, const S* theta_step) {
  const int n_theta = theta_.columns();
  S last[kStateColumns], guest_step[kStateColumns] = {};
  for (int i = count_ - 1; i >= 0; --i) {
    const bool has_guest = link_[i].join != Join::none;
    // The step that the segment after this one found for our last keyframe; none hangs on it: none is known.
    for (int c = 0; c < kStateColumns; ++c) last[c] = link_[i].passes_on ? guest_step[c] : S(0);
    if (has_guest) Chain<S>::solve_guest(kept_[i], n_theta, last, theta_step, guest_step);
    const GuestLink<S> g = guest(i);
    eliminator->eliminate(*segment_[i], g, theta_, model_, damping);
    for (int c = 0; c < kStateColumns; ++c) {
      step_[eliminator->last_column() + c] = last[c];
      if (has_guest) step_[eliminator->guest_column() + c] = guest_step[c];
    }
    for (int c = 0; c < n_theta; ++c) step_[eliminator->theta_column() + c] = theta_step[c];
    eliminator->back_substitute(*segment_[i], g, theta_, model_, damping, step_,
                                link_[i].passes_on ? eliminator->last_column() : eliminator->guest_column());
    eliminator->move(segment_[i], theta_, model_, damping, step_);
  }
}

/// Each landmark to its best place given the new poses and theta: what is most curved in the problem, the inverse
/// distances of landmarks with little parallax, no longer limits the step (Golub and Pereyra's variable projection).
template <class S>
void Calibrator<S>::refine_landmarks() {
  for (int i = 0; i < count_; ++i) {
    for (int j = 0; j < segment_[i]->n_landmarks; ++j) {
      refine_landmark(*segment_[i], j, theta_, model_, 2, &segment_[i]->states.landmark[j]);
    }
  }
}

template <class S>
void Calibrator<S>::save() {
  saved_theta_ = theta_;
  for (int i = 0; i < count_; ++i) saved_[i] = segment_[i]->states;
}

template <class S>
void Calibrator<S>::restore() {
  theta_ = saved_theta_;
  for (int i = 0; i < count_; ++i) segment_[i]->states = saved_[i];
}

/// True if this step goes against the last one (by more than 120 deg): undamped steps swing about the minimum along weak
/// directions, such as place against inverse distance when there is hardly any parallax. Keeps the step for the next time.
template <class S>
bool Calibrator<S>::turned_back(const S* theta_step) {
  S along = S(0), now = S(0), before = S(0);
  for (int i = 0; i < theta_.columns(); ++i) {
    const S a = theta_step[i] / prior_.sigma[i], b = last_step_[i];
    along += a * b;
    now += a * a;
    before += b * b;
    last_step_[i] = a;
  }
  return along < S(0) && along * along > S(0.25) * now * before;
}

/// One step: kept if the cost falls, taken back and damped more if not. True when nothing is left to gain.
template <class S>
bool Calibrator<S>::iterate(SegmentEliminator<S>* eliminator, S* damping, S* cost, const CalibratorOptions& options) {
  const int n = theta_.columns();
  linearise(eliminator, *damping);
  PackedTriangle<S> T = theta_triangle();
  S theta_step[kMaxTheta];
  S fall = S(0);
  for (int i = 0; i < n; ++i) {
    theta_step[i] = T(i, n);
    fall += T(i, n) * T(i, n);
  }
  back_substitute(T, n, theta_step);
  save();
  step_back(eliminator, *damping, theta_step);
  add_step(&theta_, theta_step);
  refine_landmarks();
  const S trial = total_cost();
  // Near the minimum the difference drowns in the rounding of the sum.
  const S rounding = (std::is_same_v<S, float> ? S(2e-6) : S(1e-13)) * *cost;
  if (!(trial <= *cost + rounding)) {
    restore();
    *damping = *damping > S(0) ? *damping * S(4) : S(0.05);
    return *damping > S(1e4);
  }
  const bool settled = fall < S(options.converged) && *cost - trial <= S(1e-3) * *cost;
  *cost = trial;
  if (turned_back(theta_step)) {
    *damping = *damping > S(0) ? *damping * S(2) : S(0.05);
  } else {
    *damping = *damping < S(0.05) ? S(0) : *damping * S(0.2);
  }
  return settled;
}

template <class S>
void Calibrator<S>::run(const CalibratorOptions& options, SegmentEliminator<S>* eliminator) {
  S damping = S(0);
  S cost = fit_.start_cost = total_cost();
  fit_.converged = false;
  for (S& s : last_step_) s = S(0);
  for (fit_.iterations = 0; fit_.iterations < options.max_iterations && !fit_.converged; ++fit_.iterations) {
    fit_.converged = iterate(eliminator, &damping, &cost, options);
  }
  fit_.cost = cost;
  linearise(eliminator, S(0));
  const S rho = theta_triangle()(theta_.columns(), theta_.columns());
  fit_.chi2 = rho * rho;
}

}  // namespace SEGCAL_NS
