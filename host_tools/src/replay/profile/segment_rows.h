// The core's own rows of a segment, eliminated once more: densely, in double, and one sensor after the other.
//
// With C, G and A the quadratic forms of camera, gyroscope and accelerometer over [states x | w], w = [theta | terms |
// rhs], landmarks eliminated, and H that of gauge and weak priors,
//     S_0 = (H + C) / x,   S_1 = (H + C + G) / x,   S_2 = (H + C + G + A) / x
// ("/ x": Schur complement, states at their best), the camera has S_0, the gyroscope S_1 - S_0, the accelerometer S_2 -
// S_1: what the images say against each other, what the gyroscope says against the turns that they see, the
// accelerometer against the motion that both see. (Each as large as the squares of a Kalman filter's innovations.
// Residuals of the joint fit would not do: between keyframes an IMU is ten times as precise as the images, so that
// nearly all of its error would stand in theirs; of 38,500 degrees of freedom 34 were the IMU's.) They add up, are
// independent, and with N_k the states' part of the k-th sum the noise of sensor t adds variance_t times tr
// N_(k-1)^-1 F_t - tr N_k^-1 F_t to the k-th, F_t its form; of its own sensor: rows - tr N_k^-1 F_k.
//
// In double, although the core's are float: nothing of a float core's own arithmetic is compiled here a second time.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>

#include "replay/core.h"
#include "replay/profile/landmark_squares.h"
#include "replay/profile/root_of_squares.h"

namespace host {
namespace SEGCAL_NS {

static_assert(behind_inverse_depth_sigma == ::SEGCAL_NS::kBehindDepthSigma<double>,
              "core.h repeats it for the reference and the noise of tracks");

class SegmentRows {
  using Index = Eigen::Index;
  using MatrixXd = Eigen::MatrixXd;

 public:
  SegmentRows(const core::Segment<double>& segment, const core::Calibration<double>& theta,
              const core::MeasurementModel<double>& model, const core::CandidateTerms& candidates)
      : segment_(segment), theta_(theta), model_(model) {
    layout_.keyframes = segment.n_keyframes;
    layout_.sensor_cameras = theta.imu_column();
    for (int i = 0; i < theta.effects.count(); ++i) add_term(theta.effects.term[i]);
    for (int i = 0; i < candidates.count(); ++i) add_term(candidates.term[i]);
    states_ = core::kStateColumns * segment.n_keyframes;
    columns_ = states_ + layout_.wide_theta() + 1;
    for (MatrixXd& form : form_) form = MatrixXd::Zero(columns_, columns_);
  }

  CoreSensorRows eliminated() {
    measured_[kCamera] = LandmarkSquares(segment_, theta_, model_, layout_, camera_term_).add_to(&form_[kCamera]);
    add_links();
    hold();
    const Index wide = columns_ - states_;
    CoreSensorRows out, nothing;
    nothing.root.fill(MatrixXd::Zero(wide, wide));
    MatrixXd sum = held_;
    Left before{MatrixXd::Zero(wide, wide)}, now;
    for (int k = kCamera; k <= kAccel; ++k) {
      sum += form_[k];
      if (!eliminate(k, sum, &now)) return nothing;
      out.root[k] = root_of_squares(now.squares - before.squares, now.squares, sum.diagonal().tail(wide));
      for (int t = kCamera; t < k; ++t) out.shared(k, t) = std::max(0.0, before.fitted(t) - now.fitted(t));
      out.shared(k, k) = measured_[k] - now.fitted(k);
      before = now;
    }
    return out;
  }

 private:
  enum Sensor { kCamera, kGyro, kAccel };
  /// Rows of a link in the order in which they are whitened: the gyroscope's know nothing of the accelerometer.
  static constexpr int kLinkRows = 15, kGyroRows = 6,
                       kOrder[kLinkRows] = {0, 1, 2, 12, 13, 14, 3, 4, 5, 6, 7, 8, 9, 10, 11};

  void add_term(const core::Term& t) {
    if (t.of_imu()) {
      imu_terms_.term[imu_terms_.n++] = t;
    } else {
      camera_term_[layout_.camera_terms] = t;
    }
    layout_.add_term(t);
  }

  /// Columns that the first k + 1 sensors touch: poses, with the gyroscope
  /// its bias, then all. The others know nothing but their priors.
  static bool is_known(Index c, int k) {
    return k == kAccel || c % core::kStateColumns < core::kPoseColumns || (k == kGyro && c % core::kStateColumns >= 12);
  }
  std::vector<Index> states_known_by(int k) const {
    std::vector<Index> out;
    for (Index c = 0; c < states_; ++c) {
      if (is_known(c, k)) out.push_back(c);
    }
    return out;
  }
  /// What the priors of the others have of the squares, eliminated.
  double alone(const MatrixXd& sum, int k) const {
    double out = 0;
    for (Index c = 0; c < states_; ++c) out += is_known(c, k) ? 0 : std::pow(sum(c, columns_ - 1), 2) / sum(c, c);
    return out;
  }

  /// What is left of the first k + 1 sensors: S_k, and for each of them tr N_k^-1 F_t, its rows that the states follow.
  struct Left {
    MatrixXd squares;
    Eigen::Vector3d fitted{0, 0, 0};
  };
  /// False where a direction is lost in rounding.
  bool eliminate(int k, const MatrixXd& sum, Left* left) const {
    const std::vector<Index> known = states_known_by(k);
    const Index wide = columns_ - states_;
    const Eigen::LLT<MatrixXd> N(sum(known, known));
    if (N.info() != Eigen::Success) return false;
    const MatrixXd cross = N.matrixL().solve(sum(known, Eigen::lastN(wide)));
    left->squares = sum.bottomRightCorner(wide, wide) - cross.transpose() * cross;
    left->squares(wide - 1, wide - 1) -= alone(sum, k);
    const MatrixXd inverse = upper_of_inverse(N.matrixLLT());
    for (int t = kCamera; t <= k; ++t) left->fitted(t) = trace_of_product(inverse, form_[t](known, known));
    return true;
  }

  /// (L L')^-1, upper triangle. Block by block what is zero costs nothing: a third of the time.
  static MatrixXd upper_of_inverse(const MatrixXd& L) {
    constexpr Index kBlock = 32;
    const Index n = L.cols();
    MatrixXd root = MatrixXd::Zero(n, n), out = MatrixXd::Zero(n, n);
    for (Index b = 0; b < n; b += kBlock) {
      const Index rest = n - b, w = std::min(kBlock, rest);
      MatrixXd part = MatrixXd::Identity(rest, w);
      L.bottomRightCorner(rest, rest).triangularView<Eigen::Lower>().solveInPlace(part);
      root.block(b, b, rest, w) = part;
    }
    for (Index b = 0; b < n; b += kBlock) {
      const Index rest = n - b, w = std::min(kBlock, rest);
      out.block(0, b, b + w, w).noalias() = root.block(b, 0, rest, b + w).transpose() * root.block(b, b, rest, w);
    }
    return out;
  }

  /// Of symmetric matrices, by their upper triangles.
  static double trace_of_product(const MatrixXd& a, const MatrixXd& b) {
    double out = 0;
    for (Index c = 0; c < a.cols(); ++c) out += 2 * a.col(c).head(c).dot(b.col(c).head(c)) + a(c, c) * b(c, c);
    return out;
  }

  void add_links() {
    const core::State<double>* x = segment_.states.x;
    for (int k = 0; k + 1 < segment_.n_keyframes; ++k) {
      const core::ImuIntegral<double> I =
          segment_.integrate(k + 1, theta_, x[k].b_a, x[k].b_g, model_.imu, &imu_terms_);
      core::ImuRows<double> rows;
      core::link_rows(I, x[k], x[k + 1], x[k], x[k + 1], model_.g, &rows);
      core::take_noise_off_scales(I, &rows);
      core::link_term_columns(rows, &imu_terms_);
      // Columns: both states, and behind them what is no state.
      constexpr Index kStates = 2 * core::kStateColumns;
      MatrixXd all = MatrixXd::Zero(kLinkRows, kStates + columns_ - states_);
      const Index imu = kStates + layout_.sensor_cameras;
      all.leftCols<kStates>() = rows.J.leftCols<kStates>();
      all.middleCols(imu, core::kImuColumns) = rows.J.rightCols<core::kImuColumns>();
      for (int t = 0; t < imu_terms_.count(); ++t) {
        for (int i = 0; i < kLinkRows; ++i)
          all(i, imu + core::kImuColumns + layout_.imu_term[t]) = imu_terms_.link[t][i];
      }
      all.rightCols<1>() = -rows.r;
      core::Mat<double, kLinkRows, kLinkRows> Q;
      core::link_covariance(I, model_.imu, &Q);
      std::vector<Index> to;
      for (Index c = 0; c < all.cols(); ++c)
        to.push_back(c < kStates ? core::kStateColumns * k + c : states_ + c - kStates);
      add_whitened(all, Q, to);
    }
  }

  /// `to`: where the rows' columns stand.
  void add_whitened(const MatrixXd& rows, const core::Mat<double, kLinkRows, kLinkRows>& covariance,
                    const std::vector<Index>& to) {
    const std::vector<int> order(kOrder, kOrder + kLinkRows);
    MatrixXd ordered = rows(order, Eigen::all);
    const MatrixXd Q = covariance(order, order);
    const Eigen::LLT<MatrixXd> llt(Q);
    if (llt.info() != Eigen::Success) return;  // of no duration
    llt.matrixL().solveInPlace(ordered);
    const auto gyro = ordered.topRows(kGyroRows), accel = ordered.bottomRows(kLinkRows - kGyroRows);
    form_[kGyro](to, to) += gyro.transpose() * gyro;
    form_[kAccel](to, to) += accel.transpose() * accel;
    measured_[kGyro] += kGyroRows;
    measured_[kAccel] += kLinkRows - kGyroRows;
  }

  /// Gauge and priors on the first keyframe, as the core's elimination has them;
  /// and for the sums that leave states open (a single camera does not know its
  /// scale) next to nothing about each: 10 rad, 100 m, 1 km/s, 1 km/s^2, 100 rad/s.
  void hold() {
    const core::State<double>& x = segment_.states.x[0];
    const Eigen::Vector3d up = x.R_GI.transpose() * (model_.g / -model_.g.norm());
    held_ = MatrixXd::Zero(columns_, columns_);
    const double hold = core::kGaugeHold<double>, open[5] = {10, 100, 1e3, 1e3, 100};
    for (Index c = 0; c < states_; ++c) held_(c, c) = std::pow(open[c % core::kStateColumns / 3], -2);
    held_.topLeftCorner<3, 3>() += hold * hold * up * up.transpose();
    held_.block<3, 3>(3, 3).diagonal().array() += hold * hold;
    const core::Vec3<double> value[3] = {x.v_GI, x.b_a, x.b_g};
    const double sigma[3] = {model_.velocity_sigma, model_.bias_a_sigma, model_.bias_g_sigma};
    for (int i = 0; i < 9; ++i) {
      const Index c = core::kPoseColumns + i, rhs = columns_ - 1;
      const double weight = std::pow(sigma[i / 3], -2), pull = value[i / 3](i % 3);
      held_(c, c) += weight;
      held_(c, rhs) = held_(rhs, c) = -pull * weight;
      held_(rhs, rhs) += pull * pull * weight;
    }
  }

  const core::Segment<double>& segment_;
  const core::Calibration<double>& theta_;
  const core::MeasurementModel<double>& model_;
  core::ReducedLayout layout_;
  core::ImuTermColumns<double> imu_terms_;
  core::Term camera_term_[core::kMaxEffectColumns + 1];
  Index states_ = 0, columns_ = 0;
  MatrixXd form_[3], held_;         ///< sums of squares over [states | theta | terms | rhs]
  double measured_[3] = {0, 0, 0};  ///< rows, less what the landmarks take
};

}  // namespace SEGCAL_NS
}  // namespace host
