#include "diagnose/gap.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace host::diagnosis {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Effects that are asked about, with the others free.
struct Asked {
  std::vector<TermGroup> groups;
  int columns = 0;
  VectorXd size;
};

Asked asked_of(const std::vector<Candidate>& candidates, const std::vector<Accepted>& accepted, int only) {
  Asked out;
  std::vector<double> size;
  std::vector<TermGroup> asked;
  for (std::size_t i = 0; i < accepted.size(); ++i) {
    const Candidate& c = candidates[accepted[i].candidate];
    if (only >= 0 && static_cast<int>(i) != only) {
      out.groups.push_back(c.columns);
      continue;
    }
    asked.push_back(c.columns);
    out.columns += c.columns.count;
    size.insert(size.end(), c.size.begin(), c.size.end());
  }
  out.groups.insert(out.groups.end(), asked.begin(), asked.end());
  out.size = Eigen::Map<const VectorXd>(size.data(), static_cast<Eigen::Index>(size.size()));
  return out;
}

Marginal marginal(const Problem& problem, const Rows& rows, const Asked& asked) {
  Marginal m = marginal_of(with_groups(with_prior(rows, problem.prior), problem.n_theta, asked.groups), asked.columns);
  m.R = m.R * asked.size.asDiagonal();
  return m;
}

/// In units of the plausible sizes. A wide prior (ten sizes) keeps directions finite that these rows do not show.
struct Estimate {
  VectorXd value;
  MatrixXd covariance;
};
Estimate estimate(const Marginal& trained, double noise) {
  const Eigen::Index m = trained.R.cols();
  const MatrixXd information = trained.R.transpose() * trained.R / noise + 0.01 * MatrixXd::Identity(m, m);
  const MatrixXd covariance = information.inverse();
  return {covariance * (trained.R.transpose() * trained.d) / noise, covariance};
}

/// One half against the other's effects.
void add_half(const Marginal& trained, const Marginal& held_out, double noise, Gap* out) {
  const Estimate effects = estimate(trained, noise);
  const VectorXd v = held_out.R * effects.value;
  const double length = v.norm();
  if (!(length > 0)) return;
  const VectorXd along = v / length;
  const VectorXd seen = held_out.R.transpose() * along;
  const double before = along.dot(held_out.d), after = before - length;
  const double expected = noise + seen.dot(effects.covariance * seen);
  out->before += before * before - noise;
  out->after_measured += after * after - expected;
  out->after_sigma += std::sqrt(2.0) * expected;  // the halves' differences are one and the same number: sigmas add up
}

/// chi2 of the held-out rows with everything that was accepted, over what the noise leaves. Floor and chi2 are measured
/// on the same residuals: chi2/dof is the better measure of the two if all is well, so that the variance of their
/// difference is the difference of their variances.
double unexplained_chi2(const Problem& problem, const std::vector<TermGroup>& groups, const Floor& floor) {
  double chi2 = 0, dof = 0;
  for (const Rows* half : {&problem.train, &problem.held_out}) {
    const Rows rows = with_groups(with_prior(*half, problem.prior), problem.n_theta, groups);
    const int n = rows.columns();
    chi2 += rows.R(n, n) * rows.R(n, n);
    dof += rows.dof - n;
  }
  const double own = 2 * floor.value * floor.value / dof, measured = floor.sigma * floor.sigma;
  const double sigma = std::sqrt(measured > 0 ? std::max(measured - own, 0.25 * measured) : own);
  const double excess = chi2 / dof - floor.value;
  return excess > decision::kOverFloor * sigma ? excess * dof : 0;
}

Gap gap_of(const Problem& problem, const Asked& asked) {
  Gap out;
  out.dof = problem.train.dof + problem.held_out.dof;
  out.floor = problem.noise;
  if (asked.columns > 0) {
    const double noise = dispersion(problem, asked.groups);
    const Marginal train = marginal(problem, problem.train, asked),
                   held_out = marginal(problem, problem.held_out, asked);
    add_half(train, held_out, noise, &out);
    add_half(held_out, train, noise, &out);
  }
  out.before = std::max(0.0, out.before);
  out.after = std::max(0.0, out.after_measured - decision::kCountsAsNone * out.after_sigma);
  return out;
}

}  // namespace

Gap held_out_gap(const Problem& problem, const std::vector<Candidate>& candidates,
                 const std::vector<Accepted>& accepted, const Floor& floor, double rest_chi2) {
  const Asked asked = asked_of(candidates, accepted, -1);
  Gap out = gap_of(problem, asked);
  out.floor = floor.value;
  out.rest = std::max(unexplained_chi2(problem, asked.groups, floor), rest_chi2);
  out.before += out.rest;
  out.after += out.rest;
  return out;
}

Trained trained_on(const Problem& training, const std::vector<Candidate>& candidates,
                   const std::vector<Accepted>& accepted) {
  const Asked asked = asked_of(candidates, accepted, -1);
  if (asked.columns == 0) return {};
  const Estimate effects = estimate(marginal(training, training.all, asked), dispersion(training, asked.groups));
  return {asked.groups, asked.size.cwiseProduct(effects.value),
          asked.size.asDiagonal() * effects.covariance * asked.size.asDiagonal()};
}

Gap fold_gap(const Problem& training, const Problem& held_out, const std::vector<Candidate>& candidates,
             const std::vector<Accepted>& accepted) {
  const Asked asked = asked_of(candidates, accepted, -1);
  Gap out;
  if (asked.columns == 0) return out;
  add_half(marginal(training, training.all, asked), marginal(held_out, held_out.all, asked),
           dispersion(training, asked.groups), &out);
  return out;
}

Gap held_out_gap_of(const Problem& problem, const std::vector<Candidate>& candidates,
                    const std::vector<Accepted>& accepted, std::size_t which) {
  return gap_of(problem, asked_of(candidates, accepted, static_cast<int>(which)));
}

}  // namespace host::diagnosis
