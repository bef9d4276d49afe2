#include "reference/judged.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "information/release_rules.h"
#include "quantile.h"
#include "reference/theta.h"
#include "replay/words.h"

namespace host::reference {
namespace {

/// Directions whose sigma stays above half the prior's, blindest first.
std::vector<CoreDirection> blind_directions(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& prior_sigma) {
  const Eigen::VectorXd inverse = prior_sigma.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  std::vector<CoreDirection> out;
  for (Eigen::Index i = prior_sigma.size() - 1; i >= 0; --i) {
    const double sigma = std::sqrt(eigen.eigenvalues()(i));
    if (sigma < SEGCAL_NS::ReleaseRules<double>{}.weak) break;
    Eigen::Index largest;
    eigen.eigenvectors().col(i).cwiseAbs().maxCoeff(&largest);
    const Eigen::VectorXd v = eigen.eigenvectors().col(i) / eigen.eigenvectors()(largest, i);
    out.push_back({std::vector<double>(v.data(), v.data() + v.size()), sigma});
  }
  return out;
}

/// Moves on with the fixed parameters held at the prior's mean.
void hold_fixed(Problem* problem, const std::vector<CoreParameter>& parameters, const SolveOptions& options) {
  const std::vector<double> sigma = problem->prior_sigma;
  bool any = false;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].verdict != "fixed") continue;
    any = true;
    problem->prior_sigma[i] *= 1e-4;
  }
  if (any) solve(problem, options);
  problem->prior_sigma = sigma;
}

}  // namespace

CoreResult judged(Problem* problem, const Fit& fit, const SolveOptions& options) {
  static constexpr SEGCAL_NS::ReleaseRules<double> rules;
  CoreResult out;
  const double ratio = fit.dof > 0 ? fit.chi2 / fit.dof : 0;
  out.noise_scale = std::sqrt(std::max({1.0, ratio, problem->scatter}));
  const Eigen::VectorXd prior = Eigen::Map<const Eigen::VectorXd>(
      problem->prior_sigma.data(), static_cast<Eigen::Index>(problem->prior_sigma.size()));
  const Eigen::VectorXd sigma = (out.noise_scale * fit.covariance.diagonal().cwiseSqrt()).cwiseMin(prior);
  const Eigen::VectorXd printed = out.noise_scale * printed_sigmas(problem->theta, fit.covariance);
  const Eigen::VectorXd initial = printed_values(problem->prior_mean);
  const std::vector<std::string> names = parameter_names(problem->theta);
  int observed = 0;
  for (Eigen::Index i = 0; i < prior.size(); ++i) {
    CoreParameter p;
    p.name = names[static_cast<std::size_t>(i)];
    p.unit = unit_of(p.name);
    const double share = sigma(i) / prior(i);
    p.verdict = share < rules.observed ? "observed" : share < rules.weak ? "weak" : "fixed";
    observed += share < rules.observed ? 1 : 0;
    p.sigma = p.unit == "rad" ? printed(i) : sigma(i);
    p.prior_sigma = prior(i);
    p.initial = initial(i);
    out.parameters.push_back(p);
  }
  const bool plausible = ratio > rules.least_chi2_per_dof && ratio < rules.most_chi2_per_dof && fit.converged;
  out.status = fit.image_points == 0          ? "insufficient"
               : !plausible                   ? "failed"
               : 2 * observed >= prior.size() ? "calibrated"
                                              : "insufficient";
  out.unobservable = blind_directions(fit.covariance, prior);
  hold_fixed(problem, out.parameters, options);
  const Eigen::VectorXd value = printed_values(problem->theta);
  for (Eigen::Index i = 0; i < prior.size(); ++i) out.parameters[static_cast<std::size_t>(i)].value = value(i);
  out.iterations = fit.iterations;
  out.partitions = fit.partitions;
  out.image_points = fit.image_points;
  out.converged = fit.converged;
  out.chi2 = fit.chi2;
  out.dof = fit.dof;
  std::vector<double> lengths = reprojection_lengths(*problem);
  double squares = 0;
  for (const double length : lengths) squares += length * length;
  if (!lengths.empty()) {
    out.reprojection_rms_px = std::sqrt(squares / static_cast<double>(lengths.size()));
    out.reprojection_median_px = middle_of(lengths);
  }
  return out;
}

}  // namespace host::reference
