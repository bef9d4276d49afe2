#include "review/segment_scatter.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "diagnose/chi_square.h"

namespace host::review {
namespace {

using diagnosis::Rows;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Eight segments tell a variance to a half: only scatter that
/// chance does not explain once in a thousand parameters is taken.
constexpr double kChance = -3;

}  // namespace

SegmentScatter scatter_of_segments(const diagnosis::Problem& problem, const MatrixXd& printed, double dispersion) {
  SegmentScatter out;
  const int n = problem.n_theta;
  out.variance_factor = VectorXd::Ones(n);
  if (problem.pieces.size() < 3) return out;
  const auto only_theta = [n](const Rows& rows) { return diagnosis::with_groups(rows, n, {}); };
  const diagnosis::Solution best = diagnosis::solve(diagnosis::with_prior(only_theta(problem.all), problem.prior));
  const MatrixXd& Sigma = best.covariance;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(Sigma);
  const MatrixXd root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
                        eigen.eigenvectors().transpose();
  const MatrixXd by_pull = printed * Sigma;  // a printed value's movement by a pull
  double found = 0, expected = 0, spread = 0;
  VectorXd value_found = VectorXd::Zero(n), value_expected = VectorXd::Zero(n), value_spread = VectorXd::Zero(n);
  for (const diagnosis::Piece& piece : problem.pieces) {
    const Rows rows = only_theta(piece.rows);
    const MatrixXd R = rows.R.leftCols(n);
    const VectorXd g = R.transpose() * (rows.R.col(n) - R * best.x);
    const MatrixXd H = R.transpose() * R, noise = dispersion * (H - H * Sigma * H);
    found += g.dot(Sigma * g);
    const MatrixXd whitened = root * noise * root;
    expected += whitened.trace();
    spread += whitened.squaredNorm();
    const VectorXd e = (by_pull * noise * by_pull.transpose()).diagonal().cwiseMax(0);
    value_found += (by_pull * g).cwiseAbs2();
    value_expected += e;
    value_spread += e.cwiseAbs2();
  }
  if (!(expected > 0)) return out;
  out.pooled = found / expected;
  out.pooled_dof = expected * expected / spread;
  const auto log10_p = [](double ratio, double dof) {
    const int whole = std::max(1, static_cast<int>(std::lround(dof)));
    return diagnosis::log10_upper_tail(ratio * whole, whole);
  };
  out.log10_p = log10_p(out.pooled, out.pooled_dof);
  const double common = out.log10_p < kChance ? std::max(1.0, out.pooled) : 1;
  for (int i = 0; i < n; ++i) {
    out.variance_factor(i) = common;
    if (!(value_expected(i) > 0)) continue;
    const double ratio = value_found(i) / value_expected(i),
                 dof = value_expected(i) * value_expected(i) / value_spread(i);
    if (ratio > common && log10_p(ratio, dof) + std::log10(static_cast<double>(n)) < kChance)
      out.variance_factor(i) = ratio;
  }
  return out;
}

}  // namespace host::review
