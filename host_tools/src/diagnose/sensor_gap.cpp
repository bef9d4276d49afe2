#include "diagnose/sensor_gap.h"

#include <cmath>

#include "diagnose/decision.h"
#include "diagnose/shift.h"

namespace host::diagnosis {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Theta and effects on a fold's own segments.
struct Best {
  VectorXd before, after;  ///< [theta | effects]: without effects, and with the trained ones
  MatrixXd by_effects;     ///< how the best of theta follows the effects, with these below
  MatrixXd theta_root;     ///< R^-1, R'R the information about theta
};

/// Rows of one sensor of a fold's own segments, stacked by sum_of.
Rows rows_of(const Fold& fold, const std::vector<Piece>& pieces, const std::vector<TermGroup>& groups) {
  Problem own;
  own.n_theta = fold.own.n_theta;
  for (std::size_t i : fold.places) own.pieces.push_back(pieces[i]);
  if (fold.shift) own = with_shift(own, *fold.shift);
  std::vector<const Rows*> rows;
  for (const Piece& p : own.pieces) rows.push_back(&p.rows);
  return with_groups(sum_of(rows), own.n_theta, groups);
}

/// The prior of theta is no measurement: wide, it holds directions
/// that the rows do not show, and hardly pulls (sensor_gap.h).
Prior wide(Prior prior) {
  prior.sigma *= decision::kWidePrior;
  return prior;
}

Best best_of(const std::array<Rows, kSensors>& sensors, const Fold& fold, const Trained& trained) {
  const int n = fold.own.n_theta;
  const auto m = trained.value.size();
  const Rows own = with_prior(sum_of({&sensors[0], &sensors[1], &sensors[2]}), wide(fold.own.prior));
  const auto R = own.R.topLeftCorner(n, n).triangularView<Eigen::Upper>();
  const VectorXd theta = R.solve(own.R.col(n + m).head(n));
  Best out;
  out.by_effects = MatrixXd::Identity(n + m, n + m).rightCols(m);
  out.by_effects.topRows(n) = -R.solve(own.R.block(0, n, n, m));
  out.before = VectorXd::Zero(n + m);
  out.before.head(n) = theta;
  out.after = out.before + out.by_effects * trained.value;
  out.theta_root = R.solve(MatrixXd::Identity(n, n));
  return out;
}

/// The pieces of the problem at which the selection ended: with a step's columns, where it has one.
SensorPieces with_step(const Selection& selection, SensorPieces pieces) {
  if (!selection.shifted) return pieces;
  for (std::vector<Piece>& of : pieces.of) {
    Problem p;
    p.n_theta = selection.problem.n_theta;
    p.pieces = of;
    of = with_shift(p, selection.shift).pieces;
  }
  if (selection.shift.straddling >= 0) pieces.shared.erase(pieces.shared.begin() + selection.shift.straddling);
  return pieces;
}

/// Sums over the folds.
struct FoldSums {
  Vector3d before{0, 0, 0}, after{0, 0, 0}, fall{0, 0, 0};
  Eigen::Matrix3d shared = Eigen::Matrix3d::Zero();
};

/// D with theta fitted as well (sensor_gap.h). `by_theta`: A_s.
Eigen::Matrix3d less_theta(const Eigen::Matrix3d& shared, const std::array<MatrixXd, kSensors>& by_theta) {
  const Vector3d dof = shared.rowwise().sum();
  const Eigen::Matrix3d of_dof = dof.cwiseMax(1e-9).cwiseInverse().asDiagonal() * shared;
  Eigen::Matrix3d both;
  Vector3d own;
  for (int s = 0; s < kSensors; ++s) {
    own(s) = by_theta[s].trace();
    for (int t = 0; t < kSensors; ++t) both(s, t) = by_theta[s].cwiseProduct(by_theta[t]).sum();
  }
  return shared + (both - 2 * Eigen::Matrix3d(own.asDiagonal())) * of_dof;
}

void add_fold(const Fold& fold, const SensorPieces& pieces, const Vector3d& variance, FoldSums* sums) {
  const Trained trained = trained_on(fold.training, fold.candidates, fold.accepted);
  std::array<Rows, kSensors> sensors;
  for (int s = 0; s < kSensors; ++s) sensors[s] = rows_of(fold, pieces.of[s], trained.groups);
  const Best best = best_of(sensors, fold, trained);
  std::array<MatrixXd, kSensors> by_theta;
  Vector3d before, after;
  for (int s = 0; s < kSensors; ++s) {
    const Rows& rows = sensors[s];
    const MatrixXd theta = rows.R.leftCols(fold.own.n_theta) * best.theta_root,
                   effects = rows.R.leftCols(rows.columns()) * best.by_effects;
    by_theta[s] = theta.transpose() * theta;
    before(s) = cost_at(rows, best.before);
    after(s) = fold.missed ? before(s) : cost_at(rows, best.after);
    sums->fall(s) += before(s) - after(s);
    if (!fold.missed) after(s) -= (effects * trained.covariance * effects.transpose()).trace();
  }
  Eigen::Matrix3d shared = Eigen::Matrix3d::Zero();
  for (std::size_t i : fold.places) shared += pieces.shared[i];
  shared = less_theta(shared, by_theta);
  const Vector3d noise = shared * variance;
  sums->shared += shared;
  sums->before += before - noise;
  sums->after += after - noise;
}

/// The sensors' squares are a second elimination of a segment (CoreSensorRows): do they add up to those of the first?
bool add_up(const SensorPieces& sensors, const std::vector<Piece>& whole) {
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const MatrixXd& R = whole[i].rows.R;
    MatrixXd sum = MatrixXd::Zero(R.cols(), R.cols());
    for (const std::vector<Piece>& of : sensors.of) sum += of[i].rows.R.transpose() * of[i].rows.R;
    const MatrixXd apart = sum - R.transpose() * R;
    const VectorXd length = R.colwise().squaredNorm().transpose().cwiseMax(sum.diagonal()).cwiseSqrt();
    const MatrixXd most = decision::kSensorsAddUp * length * length.transpose();
    if (!(apart.cwiseAbs().array() <= most.array()).all()) return false;  // nor where one is not finite
  }
  return true;
}

}  // namespace

std::array<SensorGap, kSensors> gap_by_sensor(const Selection& selection, const std::vector<Fold>& folds,
                                              const SensorPieces& pieces, const std::array<Floor, kSensors>& noise) {
  const SensorPieces stepped = with_step(selection, pieces);
  Vector3d variance, spread;
  for (int s = 0; s < kSensors; ++s) {
    variance(s) = noise[s].value;
    spread(s) = noise[s].sigma;
  }
  FoldSums sums;
  for (const Fold& fold : folds) add_fold(fold, stepped, variance, &sums);
  const Vector3d dof = sums.shared.rowwise().sum(), expected = sums.shared * variance;
  std::array<SensorGap, kSensors> out;
  if (!add_up(stepped, selection.problem.pieces)) return out;
  for (int s = 0; s < kSensors; ++s) {
    if (!(dof(s) > 0 && expected(s) > 0)) continue;
    const double measured = sums.shared.row(s).transpose().cwiseProduct(spread).norm() / expected(s);
    out[s] = {dof(s),
              expected(s) / dof(s),
              sums.before(s) / expected(s),
              sums.after(s) / expected(s),
              std::sqrt(2 / dof(s) + measured * measured),
              sums.fall(s)};
  }
  return out;
}

}  // namespace host::diagnosis
