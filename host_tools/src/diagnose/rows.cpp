#include "diagnose/rows.h"

#include <Eigen/QR>

namespace host::diagnosis {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The core hands out float: below this share of a column's length its direction is rounding.
constexpr double kCollinear = 3e-5;

}  // namespace

MatrixXd inverse_of_triangle(const MatrixXd& R) {
  const int n = static_cast<int>(R.cols());
  MatrixXd inverse = MatrixXd::Zero(n, n);
  for (int k = 0; k < n; ++k) {
    for (int i = k; i >= 0; --i) {
      double sum = i == k ? 1 : 0;
      for (int c = i + 1; c <= k; ++c) sum -= R(i, c) * inverse(c, k);
      const bool own = std::abs(R(i, i)) > kCollinear * R.col(i).norm();
      inverse(i, k) = own ? sum / R(i, i) : 0;
    }
  }
  return inverse;
}

MatrixXd triangle_of(const MatrixXd& rows) {
  const int n = static_cast<int>(rows.cols());
  MatrixXd padded = MatrixXd::Zero(std::max<Eigen::Index>(rows.rows(), n), n);
  padded.topRows(rows.rows()) = rows;
  const Eigen::HouseholderQR<MatrixXd> qr(padded);
  return MatrixXd(qr.matrixQR().topRows(n).triangularView<Eigen::Upper>());
}

Rows sum_of(const std::vector<const Rows*>& sets) {
  Rows out;
  Eigen::Index total = 0;
  for (const Rows* s : sets) total += s->R.rows();
  if (sets.empty()) return out;
  MatrixXd stacked(total, sets.front()->R.cols());
  Eigen::Index at = 0;
  for (const Rows* s : sets) {
    stacked.middleRows(at, s->R.rows()) = s->R;
    at += s->R.rows();
    out.dof += s->dof;
  }
  out.R = triangle_of(stacked);
  return out;
}

void count_from(const VectorXd& at, Rows* rows) { rows->R.col(rows->columns()) += rows->R.leftCols(at.size()) * at; }

Rows with_prior(const Rows& rows, const Prior& prior) {
  const Eigen::Index n = rows.R.cols(), m = prior.sigma.size();
  MatrixXd stacked = MatrixXd::Zero(m + rows.R.rows(), n);
  for (Eigen::Index i = 0; i < m; ++i) {
    stacked(i, i) = 1 / prior.sigma(i);
    stacked(i, n - 1) = prior.mean(i) / prior.sigma(i);
  }
  stacked.bottomRows(rows.R.rows()) = rows.R;
  return {triangle_of(stacked), rows.dof};
}

Rows with_groups(const Rows& rows, int n_theta, const std::vector<TermGroup>& groups) {
  int n = n_theta + 1;
  for (const TermGroup& g : groups) n += g.count;
  MatrixXd chosen(rows.R.rows(), n);
  chosen.leftCols(n_theta) = rows.R.leftCols(n_theta);
  int at = n_theta;
  for (const TermGroup& g : groups) {
    chosen.middleCols(at, g.count) = rows.R.middleCols(n_theta + g.first, g.count);
    at += g.count;
  }
  chosen.col(at) = rows.R.col(rows.columns());
  return {triangle_of(chosen), rows.dof};
}

double cost_at(const Rows& rows, const VectorXd& x) {
  const int n = rows.columns();
  return (rows.R.leftCols(n) * x - rows.R.col(n)).squaredNorm();
}

Solution solve(const Rows& rows) {
  const int n = rows.columns();
  const MatrixXd inverse = inverse_of_triangle(rows.R.topLeftCorner(n, n));
  Solution out;
  out.x = inverse * rows.R.col(n).head(n);
  out.covariance = inverse * inverse.transpose();
  out.cost = cost_at(rows, out.x);
  return out;
}

Marginal marginal_of(const Rows& rows, int m) {
  const int n = rows.columns();
  return {rows.R.block(n - m, n - m, m, m), rows.R.col(n).segment(n - m, m)};
}

}  // namespace host::diagnosis
