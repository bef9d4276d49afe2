// Square-root elimination of a whole segment: the one linearisation that scoring, calibration and diagnosis share
// (DESIGN, section 4; paper, Eq. (segment_cov_fim) and (cholesky)).
//
// Columns of the result R: [keyframes 15 K | guest 15, where joined | theta | rhs]. Rows from the last keyframe on are
// the segment reduced to what links it (last keyframe, guest, theta); rows from theta on are its SegmentInformation.
#pragma once

#include "segments/inertial_chain.h"
#include "segments/landmark_elimination.h"

namespace SEGCAL_NS {

/// How a segment hangs on the one before it in time.
enum class Join : std::int32_t {
  none,  ///< starts a partition: gauge and bias prior on its first keyframe
  imu,   ///< direct neighbour: the raw samples between the two are integrated
  bias   ///< gap: only the bias random walk links them; starts a partition of its own (gauge held)
};

template <class S>
struct GuestLink {
  Join join = Join::none;
  State<S> state;      ///< the previous segment's last keyframe
  S gap_s = S(0);      ///< s from there to the first keyframe (Join::bias)
};

/// Statistics of one elimination.
struct EliminationCounts {
  std::int32_t image_points = 0, landmarks = 0, residuals = 0, unknowns = 0;
};

template <class S>
class SegmentEliminator {
 public:
  /// Linearises `segment` at its states and at theta. `damping` (square root of the Levenberg-Marquardt lambda) keeps
  /// the step of states and landmarks small; 0 for none.
  void eliminate(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                 const MeasurementModel<S>& model, S damping);

  /// First column of the last keyframe, of the guest, of theta, and the number of columns.
  int last_column() const { return kStateColumns * (keyframes_ - 1); }
  int guest_column() const { return kStateColumns * keyframes_; }
  int theta_column() const { return guest_column() + guest_columns_; }
  int columns() const { return theta_column() + n_theta_ + 1; }
  PackedTriangle<S> R() { return PackedTriangle<S>(full_, columns()); }
  const EliminationCounts& counts() const { return counts_; }
  S prior_share() const { return prior_share_; }

  /// Copies the rows of theta.
  void extract(SegmentInformation<S>* out);

  /// Back-substitution: `step` holds known entries from `known` on (columns() - 1 of them all); the others are filled in.
  void back_substitute(S* step, int known);
  /// Then moves the segment's states and landmarks along `step`, linearised where eliminate() was called.
  void move(Segment<S>* segment, const Calibration<S>& theta, const MeasurementModel<S>& model, S damping, const S* step);

 private:
  void fold_landmarks(const Segment<S>& segment, const Calibration<S>& theta, const MeasurementModel<S>& model, S damping);
  void fold_links(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                  const MeasurementModel<S>& model, S damping);
  void start_partition(const Segment<S>& segment, const GuestLink<S>& guest, const MeasurementModel<S>& model);
  void damp_keyframe(S damping);
  void emit_keyframe(int k);
  void emit_chain_end();
  void fold_visual();
  void visual_row(int j, S* out);
  VisualLayout layout() const { return {6 * keyframes_, n_theta_ - kImuColumns}; }

  int keyframes_ = 0, guest_columns_ = 0, n_theta_ = 0;
  EliminationCounts counts_;
  S prior_share_ = S(0);
  LandmarkBlock<S> landmark_;
  InertialChain<S> chain_;
  static constexpr int kColumns = kStateColumns * (kMaxKeyframes + 1) + kMaxTheta + 1;
  S visual_[packed_size(kVisualColumns)];
  S full_[packed_size(kColumns)];
  S block_[6 * kColumns];
  S work_[kColumns];
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
void SegmentEliminator<S>::eliminate(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                                     const MeasurementModel<S>& model, S damping) {
  keyframes_ = segment.n_keyframes;
  guest_columns_ = guest.join == Join::none ? 0 : kStateColumns;
  n_theta_ = theta.columns();
  counts_ = EliminationCounts{};
  prior_share_ = S(0);
  R().clear();
  fold_landmarks(segment, theta, model, damping);
  fold_links(segment, guest, theta, model, damping);
  fold_visual();
  counts_.residuals += 2 * counts_.image_points;
  counts_.unknowns += 3 * counts_.landmarks + kStateColumns * keyframes_;
}

template <class S>
void SegmentEliminator<S>::fold_landmarks(const Segment<S>& segment, const Calibration<S>& theta,
                                          const MeasurementModel<S>& model, S damping) {
  const VisualLayout visual = layout();
  PackedTriangle<S> V(visual_, visual.width());
  V.clear();
  const S landmark_damping = damping / kTypicalLandmarkStep<S>;
  for (int j = 0; j < segment.n_landmarks; ++j) {
    LandmarkFit<S> fit = landmark_.build(segment, j, theta, model, visual, landmark_damping);
    if (fit.used < 2) continue;
    landmark_.eliminate(&fit, model, work_);
    fold_rows(V, landmark_.rest(), fit.rows - kLandmarkColumns, landmark_.stride(), 6 * fit.first_keyframe, visual.width(),
              work_);
    counts_.image_points += fit.used;
    ++counts_.landmarks;
    prior_share_ += fit.prior_share;
  }
}

template <class S>
void SegmentEliminator<S>::start_partition(const Segment<S>& segment, const GuestLink<S>& guest,
                                           const MeasurementModel<S>& model) {
  const State<S>& x = segment.states.x[0];
  // The gauge: position and rotation about gravity of the first keyframe. They are exactly free, so any weight holds
  // them; this one is well inside the range of float.
  const S hold = S(1e3);
  for (int i = 0; i < 3; ++i) chain_.add_scalar(3 + i, hold, S(0));
  chain_.add_rotation_row(x.R_GI.transpose() * (model.g / -square_root(model.g.squaredNorm())), hold);
  if (guest.join == Join::bias) {
    const S root = square_root(guest.gap_s);
    chain_.add_bias_link(x.b_a - guest.state.b_a, x.b_g - guest.state.b_g, S(1) / (model.imu.accel_walk * root),
                         S(1) / (model.imu.gyro_walk * root));
    return;
  }
  for (int i = 0; i < 3; ++i) {
    chain_.add_scalar(9 + i, S(1) / model.bias_a_sigma, -x.b_a(i) / model.bias_a_sigma);
    chain_.add_scalar(12 + i, S(1) / model.bias_g_sigma, -x.b_g(i) / model.bias_g_sigma);
  }
}

template <class S>
void SegmentEliminator<S>::damp_keyframe(S damping) {
  if (!(damping > S(0))) return;
  for (int c = 0; c < kStateColumns; ++c) chain_.add_scalar(c, damping / typical_step<S>(c), S(0));
}

template <class S>
void SegmentEliminator<S>::fold_links(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                                      const MeasurementModel<S>& model, S damping) {
  const State<S>* x = segment.states.x;
  ImuRows<S> rows;
  chain_.begin();
  if (guest.join == Join::imu) {
    const ImuIntegral<S> I = segment.integrate(0, theta.imu, guest.state.b_a, guest.state.b_g, model.imu);
    link_rows(I, guest.state, x[0], guest.state, x[0], model.g, &rows);
    if (whiten(I, model.imu, &rows)) chain_.add_guest_link(rows);
  } else {
    start_partition(segment, guest, model);
    counts_.unknowns -= guest.join == Join::none ? 10 : 4;  // gauge and bias prior rows are not counted as residuals
  }
  for (int i = 0; i < 3; ++i) chain_.add_scalar(6 + i, S(1) / model.velocity_sigma, -x[0].v_GI(i) / model.velocity_sigma);
  for (int k = 0; k < keyframes_; ++k) {
    damp_keyframe(damping);
    if (k + 1 == keyframes_) break;
    const ImuIntegral<S> I = segment.integrate(k + 1, theta.imu, x[k].b_a, x[k].b_g, model.imu);
    link_rows(I, x[k], x[k + 1], x[k], x[k + 1], model.g, &rows);
    if (whiten(I, model.imu, &rows)) chain_.add_next_link(rows);
    emit_keyframe(k);
    chain_.advance();
  }
  emit_chain_end();
  counts_.residuals += chain_.rows();
}

template <class S>
void SegmentEliminator<S>::emit_keyframe(int k) {
  PackedTriangle<S> F = chain_.triangle(), full = R();
  const int base = kStateColumns * k, imu = theta_column() + n_theta_ - kImuColumns;
  for (int i = 0; i < kStateColumns; ++i) {
    const S* from = F.row(i);
    S* to = full.row(base + i);
    for (int c = i; c < 2 * kStateColumns; ++c) to[base + c] = from[c];
    for (int c = 0; c < guest_columns_; ++c) to[guest_column() + c] = from[kGuestColumn + c];
    for (int c = 0; c <= kImuColumns; ++c) to[imu + c] = from[kChainImuColumn + c];
  }
}

template <class S>
void SegmentEliminator<S>::emit_chain_end() {
  PackedTriangle<S> F = chain_.triangle(), full = R();
  const int base = last_column(), imu = theta_column() + n_theta_ - kImuColumns;
  for (int i = 0; i < kStateColumns; ++i) {
    const S* from = F.row(i);
    S* to = full.row(base + i);
    for (int c = i; c < kStateColumns; ++c) to[base + c] = from[c];
    for (int c = 0; c < guest_columns_; ++c) to[guest_column() + c] = from[kGuestColumn + c];
    for (int c = 0; c <= kImuColumns; ++c) to[imu + c] = from[kChainImuColumn + c];
  }
  for (int i = 0; i < guest_columns_; ++i) {
    const S* from = F.row(kGuestColumn + i);
    S* to = full.row(guest_column() + i);
    for (int c = i; c < kStateColumns; ++c) to[guest_column() + c] = from[kGuestColumn + c];
    for (int c = 0; c <= kImuColumns; ++c) to[imu + c] = from[kChainImuColumn + c];
  }
  for (int i = 0; i <= kImuColumns; ++i) {
    const S* from = F.row(kChainImuColumn + i);
    S* to = full.row(imu + i);
    for (int c = i; c <= kImuColumns; ++c) to[imu + c] = from[kChainImuColumn + c];
  }
}

/// Row j of the visual triangle, spread to the columns of R.
template <class S>
void SegmentEliminator<S>::visual_row(int j, S* out) {
  const VisualLayout visual = layout();
  const PackedTriangle<S> V(visual_, visual.width());
  const S* from = V.row(j);
  for (int c = 0; c < columns(); ++c) out[c] = S(0);
  for (int c = j; c < visual.poses; ++c) out[kStateColumns * (c / 6) + c % 6] = from[c];
  const int camera = j > visual.poses ? j : visual.poses;
  for (int c = camera; c < visual.poses + visual.cameras; ++c) out[theta_column() + c - visual.poses] = from[c];
  out[columns() - 1] = from[visual.poses + visual.cameras];
}

template <class S>
void SegmentEliminator<S>::fold_visual() {
  const VisualLayout visual = layout();
  PackedTriangle<S> full = R();
  for (int j = 0; j < visual.width(); j += 6) {
    const int rows = visual.width() - j < 6 ? visual.width() - j : 6;
    for (int i = 0; i < rows; ++i) visual_row(j + i, block_ + i * columns());
    const int first = j < visual.poses ? kStateColumns * (j / 6) : theta_column();
    fold_rows(full, block_, rows, columns(), first, columns(), work_);
  }
}

template <class S>
void SegmentEliminator<S>::extract(SegmentInformation<S>* out) {
  out->n_theta = n_theta_;
  out->dof = counts_.residuals - counts_.unknowns;
  PackedTriangle<S> full = R(), info = out->triangle();
  for (int i = 0; i <= n_theta_; ++i) {
    for (int c = i; c <= n_theta_; ++c) info.row(i)[c] = full.row(theta_column() + i)[theta_column() + c];
  }
}

template <class S>
void SegmentEliminator<S>::back_substitute(S* step, int known) {
  const PackedTriangle<S> full = R();
  const int n = columns() - 1;
  for (int j = known - 1; j >= 0; --j) {
    const S* r = full.row(j);
    S sum = r[n];
    for (int c = j + 1; c < n; ++c) sum -= r[c] * step[c];
    step[j] = r[j] == S(0) ? S(0) : sum / r[j];
  }
}

template <class S>
void SegmentEliminator<S>::move(Segment<S>* segment, const Calibration<S>& theta, const MeasurementModel<S>& model,
                                S damping, const S* step) {
  const VisualLayout visual = layout();
  // Steps of poses and cameras side by side, as the landmark rows have them.
  for (int c = 0; c < visual.poses; ++c) work_[c] = step[kStateColumns * (c / 6) + c % 6];
  for (int c = 0; c < visual.cameras; ++c) work_[visual.poses + c] = step[theta_column() + c];
  for (int j = 0; j < segment->n_landmarks; ++j) {
    LandmarkFit<S> fit = landmark_.build(*segment, j, theta, model, visual, damping / kTypicalLandmarkStep<S>);
    if (fit.used < 2) continue;
    landmark_.eliminate(&fit, model, block_);
    S landmark_step[kLandmarkColumns];
    landmark_.solve(work_, landmark_step);
    add_step(&segment->states.landmark[j], landmark_step);
  }
  for (int k = 0; k < keyframes_; ++k) segment->states.x[k].add(step + kStateColumns * k);
}

}  // namespace SEGCAL_NS
