// The tests of one candidate.
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "diagnose/chi_square.h"
#include "diagnose/decision.h"
#include "diagnose/selection.h"
#include "formatted.h"

namespace host::diagnosis {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Marginal marginal(const Problem& problem, const Rows& rows, const Candidate& candidate,
                  const std::vector<TermGroup>& free) {
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
  const MatrixXd information =
      R.transpose() * R + MatrixXd::Identity(R.cols(), R.cols()) / (decision::kWidePrior * decision::kWidePrior);
  Posterior out;
  out.covariance = information.inverse();
  out.value = out.covariance * (R.transpose() * m.d / std::sqrt(noise));
  return out;
}

/// Cost of the best theta (and shared columns) where the first `m` columns of each piece have values of their own:
/// these are eliminated piece by piece, what is left of all pieces is solved together.
struct OwnValues {
  double cost = 0;
  int rank = 0;  ///< of the own values, all pieces
};
OwnValues cost_with_own_values(const Problem& problem, const std::vector<Rows>& pieces, int m) {
  std::vector<Rows> rest;
  OwnValues out;
  for (const Rows& piece : pieces) {
    const int n = piece.columns() - m;
    std::vector<int> own;  // a step has no columns before it
    for (int c = n; c < n + m; ++c) {
      if (piece.R.col(c).squaredNorm() > 0) own.push_back(c);
    }
    const int k = static_cast<int>(own.size());
    MatrixXd own_first(piece.R.rows(), k + n + 1);
    for (int i = 0; i < k; ++i) own_first.col(i) = piece.R.col(own[i]);
    own_first.middleCols(k, n) = piece.R.leftCols(n);
    own_first.rightCols(1) = piece.R.rightCols(1);
    const MatrixXd R = triangle_of(own_first);
    out.rank += k;
    rest.push_back({R.bottomRightCorner(R.rows() - k, n + 1), piece.dof});
  }
  std::vector<const Rows*> pointers;
  for (const Rows& r : rest) pointers.push_back(&r);
  out.cost = solve(with_prior(sum_of(pointers), problem.prior)).cost;
  return out;
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
  // Square, so it needs no QR before; without its code this file compiles in two thirds of the time.
  using SquareSvd = Eigen::JacobiSVD<MatrixXd, Eigen::NoQRPreconditioner>;
  const SquareSvd svd(m.R * size.asDiagonal() / std::sqrt(noise), Eigen::ComputeFullU | Eigen::ComputeFullV);
  const VectorXd along = svd.matrixU().transpose() * m.d / std::sqrt(noise);
  EffectTest out;
  for (Eigen::Index i = 0; i < along.size(); ++i) {
    // Along direction i, d ~ N(0, 1) without the effect and N(0, 1 + g^2) with it.
    const double g2 = svd.singularValues()(i) * svd.singularValues()(i);
    out.log_evidence += 0.5 * (along(i) * along(i) * g2 / (1 + g2) - std::log1p(g2));
    if (svd.singularValues()(i) < decision::kSeen) continue;
    ++out.seen;
    out.statistic += along(i) * along(i);
  }
  out.chi2 = out.statistic * noise;
  out.largest_gain = svd.singularValues()(0);
  out.log10_p = log10_upper_tail(out.statistic, out.seen);
  const Posterior p = posterior(m, size, noise);
  out.value = size.cwiseProduct(p.value);
  out.sigma = size.cwiseProduct(p.covariance.diagonal().cwiseSqrt());
  return out;
}

EffectTest test_alone(const Problem& problem, const Candidate& candidate) {
  EffectTest out = test_effect(problem, candidate, {});
  if (!candidate.beside.empty() && test_effect(problem, candidate, candidate.beside).seen == 0) out.seen = 0;
  return out;
}

double Scatter::log10_p(double statistic, int seen) const {
  return dof > 0 ? log10_upper_tail_of_ratio(statistic / (factor * std::max(1, seen)), seen, dof)
                 : log10_upper_tail(statistic, seen);
}

Scatter scatter_over_time(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free) {
  const int pieces = static_cast<int>(problem.pieces.size()), m = candidate.columns.count;
  if (pieces < 4) return {};
  std::vector<TermGroup> groups = free;
  groups.push_back(candidate.columns);
  std::vector<Rows> rows;
  std::vector<const Rows*> pointers;
  for (const Piece& p : problem.pieces) rows.push_back(with_groups(p.rows, problem.n_theta, groups));
  for (const Rows& r : rows) pointers.push_back(&r);
  const double one = solve(with_prior(sum_of(pointers), problem.prior)).cost;
  const OwnValues each = cost_with_own_values(problem, rows, m);
  const int dof = each.rank - m;
  if (dof <= 0) return {};
  return {std::max(1.0, (one - each.cost) / dispersion(problem, groups) / dof), dof};
}

EffectTest judge_effect(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free) {
  EffectTest out = test_effect(problem, candidate, free);
  const Scatter scatter = scatter_over_time(problem, candidate, free);
  out.log10_p = scatter.log10_p(out.statistic, out.seen);
  out.statistic /= scatter.factor;
  out.sigma *= std::sqrt(scatter.factor);
  return out;
}

bool called(double log10_p, double share) { return log10_p < decision::kLog10Level + std::log10(share); }

HalvesTest test_halves(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free) {
  const double noise = dispersion(problem, free);
  const VectorXd size = sizes(candidate);
  const Marginal of[2] = {marginal(problem, problem.train, candidate, free),
                          marginal(problem, problem.held_out, candidate, free)};
  const Posterior p[2] = {posterior(of[0], size, noise), posterior(of[1], size, noise)};
  const VectorXd difference = p[0].value - p[1].value, mean = 0.5 * (p[0].value + p[1].value);
  HalvesTest out;
  const MatrixXd allowed =
      p[0].covariance + p[1].covariance + decision::kCurvature * decision::kCurvature * mean * mean.transpose();
  const double s = difference.dot(allowed.inverse() * difference);
  out.log10_p_disagree = log10_upper_tail(s, static_cast<int>(size.size()));
  for (int k = 0; k < 2; ++k) {
    const MatrixXd R = of[k].R * size.asDiagonal();
    const double fall = of[k].d.squaredNorm() - (R * p[1 - k].value - of[k].d).squaredNorm();
    out.gain += fall / noise + (R * p[1 - k].covariance * R.transpose()).trace() / noise;
  }
  return out;
}

std::string halves_refuse(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free) {
  const HalvesTest halves = test_halves(problem, candidate, free);
  if (halves.log10_p_disagree < decision::kLog10Disagree)
    return formatted("the halves of the recording disagree about it (p = 1e%.0f)", halves.log10_p_disagree);
  if (halves.gain <= decision::kHelps * test_effect(problem, candidate, free).statistic)
    return "its value from one half of the recording does not help the other";
  return {};
}

}  // namespace host::diagnosis
