// The tests of one candidate.
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "diagnose/chi_square.h"
#include "diagnose/selection.h"

namespace host::diagnosis {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A direction counts as seen where its sigma is below a third of the plausible size.
constexpr double kSeen = 3;

/// Share of a value that its linearisation far away may be wrong by: halves that differ by less agree.
constexpr double kCurvature = 0.1;

Marginal marginal(const Problem& problem, const Rows& rows, const Candidate& candidate, const std::vector<TermGroup>& free) {
  std::vector<TermGroup> groups = free;
  groups.push_back(candidate.columns);
  return marginal_of(with_groups(with_prior(rows, problem.prior), problem.n_theta, groups), candidate.columns.count);
}

VectorXd sizes(const Candidate& candidate) {
  return Eigen::Map<const VectorXd>(candidate.size.data(), static_cast<Eigen::Index>(candidate.size.size()));
}

/// Value and covariance in units of the sizes, with a wide prior (ten sizes) that keeps unseen directions finite.
struct Posterior {
  VectorXd value;
  MatrixXd covariance;
};
Posterior posterior(const Marginal& m, const VectorXd& size, double noise) {
  const MatrixXd R = m.R * size.asDiagonal() / std::sqrt(noise);
  const MatrixXd information = R.transpose() * R + 0.01 * MatrixXd::Identity(R.cols(), R.cols());
  Posterior out;
  out.covariance = information.inverse();
  out.value = out.covariance * (R.transpose() * m.d / std::sqrt(noise));
  return out;
}

/// The last m columns moved to the k-th of `places` groups of m.
Rows spread(const Rows& rows, int m, int k, int places) {
  const int n = rows.columns() - m;
  MatrixXd wide = MatrixXd::Zero(rows.R.rows(), n + m * places + 1);
  wide.leftCols(n) = rows.R.leftCols(n);
  wide.middleCols(n + k * m, m) = rows.R.middleCols(n, m);
  wide.rightCols(1) = rows.R.rightCols(1);
  return {wide, rows.dof};
}

struct Solved {
  double cost = 0;
  int rank = 0;
};
Solved cost_and_rank(const Problem& problem, const std::vector<Rows>& pieces) {
  std::vector<const Rows*> pointers;
  for (const Rows& p : pieces) pointers.push_back(&p);
  const Solution solution = solve(with_prior(sum_of(pointers), problem.prior));
  return {solution.cost, static_cast<int>((solution.covariance.diagonal().array() > 0).count())};
}

}  // namespace

double dispersion(const Problem& problem, const std::vector<TermGroup>& free) {
  const Rows rows = with_groups(with_prior(problem.all, problem.prior), problem.n_theta, free);
  const int n = rows.columns();
  const double dof = rows.dof - n, rho = rows.R(n, n);
  return std::max(problem.noise, dof > 0 ? rho * rho / dof : 0);
}

EffectTest test_effect(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free) {
  const double noise = dispersion(problem, free);
  const Marginal m = marginal(problem, problem.all, candidate, free);
  const VectorXd size = sizes(candidate);
  const Eigen::JacobiSVD<MatrixXd> svd(m.R * size.asDiagonal() / std::sqrt(noise), Eigen::ComputeFullU | Eigen::ComputeFullV);
  const VectorXd along = svd.matrixU().transpose() * m.d / std::sqrt(noise);
  EffectTest out;
  for (Eigen::Index i = 0; i < along.size(); ++i) {
    if (svd.singularValues()(i) < kSeen) continue;
    ++out.seen;
    out.statistic += along(i) * along(i);
  }
  out.largest_gain = svd.singularValues()(0);
  out.log10_p = log10_upper_tail(out.statistic, out.seen);
  const Posterior p = posterior(m, size, noise);
  out.value = size.cwiseProduct(p.value);
  out.sigma = size.cwiseProduct(p.covariance.diagonal().cwiseSqrt());
  return out;
}

double Scatter::log10_p(double statistic, int seen) const {
  return dof > 0 ? log10_upper_tail_of_ratio(statistic / (factor * std::max(1, seen)), seen, dof) : log10_upper_tail(statistic, seen);
}

Scatter scatter_over_time(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free) {
  const int pieces = static_cast<int>(problem.pieces.size()), m = candidate.columns.count;
  if (pieces < 4) return {};
  std::vector<TermGroup> groups = free;
  groups.push_back(candidate.columns);
  std::vector<Rows> shared, own;
  for (int k = 0; k < pieces; ++k) {
    shared.push_back(with_groups(problem.pieces[k].rows, problem.n_theta, groups));
    own.push_back(spread(shared.back(), m, k, pieces));
  }
  const Solved one = cost_and_rank(problem, shared), each = cost_and_rank(problem, own);
  const double noise = dispersion(problem, groups), drop = (one.cost - each.cost) / noise;
  const int dof = each.rank - one.rank;
  if (dof <= 0) return {};
  return {std::max(1.0, drop / dof), dof};
}

HalvesTest test_halves(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free) {
  const double noise = dispersion(problem, free);
  const VectorXd size = sizes(candidate);
  const Marginal of[2] = {marginal(problem, problem.train, candidate, free), marginal(problem, problem.held_out, candidate, free)};
  const Posterior p[2] = {posterior(of[0], size, noise), posterior(of[1], size, noise)};
  const VectorXd difference = p[0].value - p[1].value, mean = 0.5 * (p[0].value + p[1].value);
  HalvesTest out;
  const MatrixXd allowed = p[0].covariance + p[1].covariance + kCurvature * kCurvature * mean * mean.transpose();
  const double s = difference.dot(allowed.inverse() * difference);
  out.log10_p_disagree = log10_upper_tail(s, static_cast<int>(size.size()));
  for (int k = 0; k < 2; ++k) {
    const MatrixXd R = of[k].R * size.asDiagonal();
    const double fall = of[k].d.squaredNorm() - (R * p[1 - k].value - of[k].d).squaredNorm();
    out.gain += fall / noise + (R * p[1 - k].covariance * R.transpose()).trace() / noise;
  }
  return out;
}

}  // namespace host::diagnosis
