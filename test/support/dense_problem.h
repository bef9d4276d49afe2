// The same least-squares problem as the core's elimination, stacked as one dense matrix and solved by Eigen in double.
//
// Columns: for each segment [states 15 K | landmarks 3 L], then theta and candidate terms; the right-hand side apart.
// Only the rows of single measurements (reprojection_rows, link_rows) come from the core; order, whitening, weights and
// priors are written here. Landmarks that segments share stand in the columns of the first segment that has them.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <vector>

#include "calibration/prior.h"
#include "segments/elimination.h"

namespace test {

using namespace SEGCAL_NS;

/// Landmark `landmark` of segment `segment` is that landmark of an earlier segment.
struct SameLandmark {
  int segment, landmark, first_segment, first_landmark;
};

class DenseProblem {
 public:
  DenseProblem(const std::vector<const Segment<double>*>& segments, const Calibration<double>& theta,
               const MeasurementModel<double>& model, double damping, const std::vector<SameLandmark>& same = {},
               const CandidateTerms& candidates = {})
      : segments_(segments), theta_(theta), model_(model), damping_(damping), same_(same) {
    for (int i = 0; i < theta.effects.count(); ++i) terms_.push_back(theta.effects.term[i]);
    for (int i = 0; i < candidates.count(); ++i) terms_.push_back(candidates.term[i]);
    for (const Segment<double>* s : segments) {
      first_.push_back(nuisance_);
      nuisance_ += kStateColumns * s->n_keyframes;
      landmark_.emplace_back(s->n_landmarks, -1);
      for (const SameLandmark& l : same) {
        if (l.segment + 1u == first_.size())
          landmark_.back()[l.landmark] = landmark_[l.first_segment][l.first_landmark];
      }
      for (int& column : landmark_.back()) {
        if (column >= 0) continue;
        column = nuisance_;
        nuisance_ += 3;
      }
    }
    for (std::size_t i = 0; i < segments.size(); ++i) add_segment(static_cast<int>(i));
  }

  int state_column(int s, int k) const { return first_[s] + kStateColumns * k; }
  int landmark_column(int s, int j) const { return landmark_[s][j]; }
  int theta_column() const { return nuisance_; }
  /// Theta with candidates.
  int wide() const { return theta_.effect_column() + static_cast<int>(terms_.size()); }
  int columns() const { return nuisance_ + wide(); }

  /// Segment s hangs on the segment before it.
  void join(int s, Join how, double gap_s) {
    const Segment<double>& segment = *segments_[s];
    const int k = segments_[s - 1]->n_keyframes - 1;
    const State<double>&guest = segments_[s - 1]->states.x[k], &x = segment.states.x[0];
    if (how == Join::imu) {
      ImuTermColumns<double> terms = imu_terms();
      const ImuIntegral<double> I = segment.integrate(0, theta_, guest.b_a, guest.b_g, model_.imu, &terms);
      add_link(I, guest, x, state_column(s - 1, k), state_column(s, 0), terms);
      return;
    }
    for (int i = 0; i < 6; ++i) {
      const double w = 1 / ((i < 3 ? model_.imu.accel_walk : model_.imu.gyro_walk) * std::sqrt(gap_s));
      const double r = i < 3 ? x.b_a(i) - guest.b_a(i) : x.b_g(i - 3) - guest.b_g(i - 3);
      Eigen::VectorXd row = Eigen::VectorXd::Zero(columns());
      row(state_column(s, 0) + 9 + i) = w;
      row(state_column(s - 1, k) + 9 + i) = -w;
      add_row(row, -w * r);
    }
  }

  /// Position and yaw of a segment's first keyframe are held.
  void hold_gauge(int s) {
    const State<double>& x = segments_[s]->states.x[0];
    const Vec3<double> up = x.R_GI.transpose() * -model_.g.normalized();
    Eigen::VectorXd row = Eigen::VectorXd::Zero(columns());
    row.segment<3>(state_column(s, 0)) = 1e5 * up;
    add_row(row, 0);
    for (int i = 0; i < 3; ++i) add_single(state_column(s, 0) + 3 + i, 1e5, 0);
  }

  void add_bias_prior(int s) {
    const State<double>& x = segments_[s]->states.x[0];
    for (int i = 0; i < 3; ++i) {
      add_single(state_column(s, 0) + 9 + i, 1 / model_.bias_a_sigma, x.b_a(i));
      add_single(state_column(s, 0) + 12 + i, 1 / model_.bias_g_sigma, x.b_g(i));
    }
  }

  void add_theta_prior(const ThetaPrior<double>& prior) {
    double offset[kMaxTheta];
    difference(prior.mean, theta_, offset);
    for (int i = 0; i < theta_.columns(); ++i) {
      add_single(theta_column() + i, 1 / prior.sigma[i], offset[i]);
      if (damping_ > 0) add_single(theta_column() + i, damping_ / (0.1 * prior.sigma[i]), 0);
    }
  }

  /// [theta | rhs] after all other columns have been eliminated: any number of rows, no triangle.
  Eigen::MatrixXd reduced() const {
    Eigen::MatrixXd left(rows_.size(), nuisance_), right(rows_.size(), wide() + 1);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      left.row(i) = rows_[i].head(nuisance_).transpose();
      right.row(i) << rows_[i].tail(wide()).transpose(), rhs_[i];
    }
    right.applyOnTheLeft(Eigen::HouseholderQR<Eigen::MatrixXd>(left).householderQ().adjoint());
    return right.bottomRows(right.rows() - nuisance_);
  }

  /// [every unknown | rhs], and the sensor that each row is a measurement of.
  Eigen::MatrixXd rows() const {
    Eigen::MatrixXd out(rows_.size(), columns() + 1);
    for (std::size_t i = 0; i < rows_.size(); ++i)
      out.row(static_cast<Eigen::Index>(i)) << rows_[i].transpose(), rhs_[i];
    return out;
  }
  enum Sensor { kPrior, kCamera, kGyro, kAccel };
  const std::vector<Sensor>& sensors() const { return sensors_; }

  /// The step of every unknown.
  Eigen::VectorXd solution() const {
    Eigen::MatrixXd A(rows_.size(), columns());
    Eigen::VectorXd b(rows_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      A.row(i) = rows_[i].transpose();
      b(i) = rhs_[i];
    }
    return A.householderQr().solve(b);
  }

 private:
  void add_row(const Eigen::VectorXd& row, double rhs, Sensor sensor = kPrior) {
    rows_.push_back(row);
    rhs_.push_back(rhs);
    sensors_.push_back(sensor);
  }
  /// weight (x + step - 0): one variable with its present value.
  void add_single(int column, double weight, double value) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(columns());
    row(column) = weight;
    add_row(row, -weight * value);
  }

  void add_segment(int s) {
    const Segment<double>& segment = *segments_[s];
    for (int i = 0; i < 3; ++i)
      add_single(state_column(s, 0) + 6 + i, 1 / model_.velocity_sigma, segment.states.x[0].v_GI(i));
    for (int k = 0; k < segment.n_keyframes; ++k) damp_state(state_column(s, k));
    for (int k = 0; k + 1 < segment.n_keyframes; ++k) {
      const State<double>* x = segment.states.x + k;
      ImuTermColumns<double> terms = imu_terms();
      const ImuIntegral<double> I = segment.integrate(k + 1, theta_, x[0].b_a, x[0].b_g, model_.imu, &terms);
      add_link(I, x[0], x[1], state_column(s, k), state_column(s, k + 1), terms);
    }
    for (int j = 0; j < segment.n_landmarks; ++j) add_landmark(s, j);
  }

  void damp_state(int column) {
    if (damping_ == 0) return;
    const double typical[5] = {0.01, 0.02, 0.05, 0.05, 0.005};
    for (int i = 0; i < kStateColumns; ++i) add_single(column + i, damping_ / typical[i / 3], 0);
  }

  bool is_tie(int s, int j) const {
    return std::any_of(same_.begin(), same_.end(),
                       [&](const SameLandmark& l) { return l.first_segment == s && l.first_landmark == j; });
  }

  void add_depth_prior(int s, int j, const DepthPrior<double>& prior) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(columns());
    row.segment<3>(landmark_column(s, j)) = prior.row.l;
    row.segment<6>(state_column(s, prior.keyframe)) = prior.row.pose;
    row.segment<6>(theta_column() + theta_.camera_column(prior.camera)) = prior.row.extrinsics;
    add_row(row, -prior.r);
  }

  void add_landmark(int s, int j) {
    const Segment<double>& segment = *segments_[s];
    const Landmark<double>& l = segment.states.landmark[j];
    const bool own = landmark_column(s, j) > state_column(s, 0);
    if (own && is_tie(s, j)) {  // no segment's camera is the first: from the fixed point
      add_single(landmark_column(s, j) + 2, 1 / model_.depth_sigma(l.rho, false), l.rho);
    } else if (own) {
      add_depth_prior(s, j, depth_prior(segment, j, l, theta_, model_));
    }
    if (own && damping_ > 0) {
      for (int i = 0; i < 3; ++i) add_single(landmark_column(s, j) + i, damping_ / 0.02, 0);
    }
    const std::size_t first_row = rows_.size();
    points_.clear();
    for (int o = segment.first_observation[j]; o < segment.first_observation[j + 1]; ++o)
      add_observation(s, j, segment.observation[o]);
    if (model_.track_walk > 0) whiten_tracks(segment, first_row);
  }

  /// The rows from `first_row` on, in px and two for each of points_, by their covariance as a matrix.
  void whiten_tracks(const Segment<double>& segment, std::size_t first_row) {
    const auto n = static_cast<Eigen::Index>(points_.size());
    Eigen::MatrixXd r(n, 2), white = Eigen::MatrixXd::Identity(n, n);
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(n, n);  // a point's walk is the sum of the steps so far of its camera
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n);     // px^2
    for (Eigen::Index a = 0; a < n; ++a) {
      const Observation& z = points_[static_cast<std::size_t>(a)];
      for (Eigen::Index b = 0; b < a; ++b) {
        const Observation& y = points_[static_cast<std::size_t>(b)];
        if (y.camera != z.camera) continue;
        sums.row(a) = sums.row(b);
        step(a) = std::pow(model_.track_walk, 2) * 1e-6 * (segment.t_us[z.keyframe] - segment.t_us[y.keyframe]);
      }
      if (step(a) > 0) sums(a, a) = 1;
      for (int i = 0; i < 2; ++i)
        r(a, i) = -rhs_[first_row + 2 * static_cast<std::size_t>(a) + static_cast<std::size_t>(i)];
    }
    white *= model_.pixel_sigma * model_.pixel_sigma;
    Eigen::VectorXd weighted = step;
    Eigen::MatrixXd walk;
    for (int round = 0; round < 200; ++round) {
      walk = sums * weighted.asDiagonal() * sums.transpose();
      const Eigen::MatrixXd solved = (walk + white).llt().solve(r);
      const Eigen::MatrixXd taken = weighted.asDiagonal() * sums.transpose() * solved;
      const Eigen::MatrixXd rest = r - walk * (walk + white).llt().solve(r);
      for (Eigen::Index a = 0; a < n; ++a) {
        const double e = rest.row(a).norm() / model_.pixel_sigma;
        white(a, a) = model_.pixel_sigma * model_.pixel_sigma * std::max(1.0, e / model_.huber);
        if (step(a) > 0) weighted(a) = step(a) * std::max(1.0, taken.row(a).norm() / std::sqrt(step(a)) / model_.huber);
      }
    }
    const Eigen::MatrixXd W = Eigen::MatrixXd((walk + white).llt().matrixL()).inverse();
    for (std::size_t i = 0; i < 2; ++i) {
      Eigen::MatrixXd rows(n, columns() + 1);
      for (Eigen::Index a = 0; a < n; ++a) {
        const std::size_t at = first_row + 2 * static_cast<std::size_t>(a) + i;
        rows.row(a) << rows_[at].transpose(), rhs_[at];
      }
      rows = (W * rows).eval();
      for (Eigen::Index a = 0; a < n; ++a) {
        const std::size_t at = first_row + 2 * static_cast<std::size_t>(a) + i;
        rows_[at] = rows.row(a).head(columns()).transpose();
        rhs_[at] = rows(a, columns());
      }
    }
  }

  void add_observation(int s, int j, const Observation& z) {
    const Exposure<double> at = exposure_of(*segments_[s], z, theta_, model_.g, true);
    ReprojectionRows<double> rows;
    if (!point_rows<double>(z, theta_, at, segments_[s]->states.landmark[j], nullptr, &rows)) return;
    const double e = rows.r.norm() / model_.pixel_sigma;
    const double weighted = std::sqrt(e > model_.huber ? model_.huber / e : 1.0) / model_.pixel_sigma;
    const double scale = model_.track_walk > 0 ? 1 : weighted;
    points_.push_back(z);
    const int n_camera = theta_.camera[z.camera].columns();
    for (int i = 0; i < 2; ++i) {
      Eigen::VectorXd row = Eigen::VectorXd::Zero(columns());
      row.segment<3>(landmark_column(s, j)) = scale * rows.J_l.row(i).transpose();
      row.segment<6>(state_column(s, z.keyframe)) = scale * rows.J_pose.row(i).transpose();
      row.segment(theta_column() + theta_.camera_column(z.camera), n_camera) =
          scale * rows.J_camera.row(i).head(n_camera).transpose();
      for (std::size_t t = 0; t < terms_.size(); ++t) {
        if (terms_[t].of_imu()) continue;
        row(term_column(t)) = scale * camera_term_column(terms_[t], z, theta_, at, false, rows)(i);
      }
      add_row(row, -scale * rows.r(i), kCamera);
    }
  }

  int term_column(std::size_t t) const { return theta_column() + theta_.effect_column() + static_cast<int>(t); }

  ImuTermColumns<double> imu_terms() const {
    ImuTermColumns<double> columns;
    for (const Term& t : terms_) {
      if (t.of_imu()) columns.term[columns.n++] = t;
    }
    return columns;
  }

  void add_link(const ImuIntegral<double>& I, const State<double>& x0, const State<double>& x1, int column0,
                int column1, ImuTermColumns<double>& terms) {
    ImuRows<double> rows;
    link_rows(I, x0, x1, x0, x1, model_.g, &rows);
    take_noise_off_scales(I, &rows);
    link_term_columns(rows, &terms);
    Eigen::MatrixXd J_terms(15, terms.n);
    for (int t = 0; t < terms.n; ++t) J_terms.col(t) = Eigen::Map<const Eigen::VectorXd>(terms.link[t], 15);
    Mat<double, 15, 15> covariance;
    link_covariance(I, model_.imu, &covariance);
    // The gyroscope's rows first, rotation and walk: then they hold nothing of the accelerometer.
    const std::vector<int> order{0, 1, 2, 12, 13, 14, 3, 4, 5, 6, 7, 8, 9, 10, 11};
    const Eigen::MatrixXd Q = covariance(order, order);
    const Eigen::LLT<Eigen::MatrixXd> llt(Q);
    const Eigen::MatrixXd J = llt.matrixL().solve(Eigen::MatrixXd(rows.J(order, Eigen::all)));
    const Eigen::VectorXd r = llt.matrixL().solve(Eigen::VectorXd(rows.r(order)));
    if (terms.n > 0) J_terms = llt.matrixL().solve(Eigen::MatrixXd(J_terms(order, Eigen::all))).eval();
    for (int i = 0; i < 15; ++i) {
      Eigen::VectorXd row = Eigen::VectorXd::Zero(columns());
      row.segment<15>(column0) = J.row(i).head<15>().transpose();
      row.segment<15>(column1) = J.row(i).segment<15>(15).transpose();
      row.segment<15>(theta_column() + theta_.imu_column()) = J.row(i).tail<15>().transpose();
      for (std::size_t t = 0, of_imu = 0; t < terms_.size(); ++t) {
        if (terms_[t].of_imu()) row(term_column(t)) = J_terms(i, static_cast<int>(of_imu++));
      }
      add_row(row, -r(i), i < 6 ? kGyro : kAccel);
    }
  }

  std::vector<const Segment<double>*> segments_;
  std::vector<Observation> points_;  ///< of the landmark that is being added, with a row for each axis
  Calibration<double> theta_;
  MeasurementModel<double> model_;
  double damping_;
  std::vector<SameLandmark> same_;
  std::vector<Term> terms_;  ///< of theta, then candidates
  int nuisance_ = 0;
  std::vector<int> first_;
  std::vector<std::vector<int>> landmark_;  ///< first column of each
  std::vector<Eigen::VectorXd> rows_;
  std::vector<double> rhs_;
  std::vector<Sensor> sensors_;
};

}  // namespace test
