#include "review/suspected_moves.h"

#include <algorithm>
#include <cmath>

#include "information/release_rules.h"

namespace host::review {
namespace {

/// By parameter: by what its sigma is short of noise and movement together; 0 where it is fixed.
std::vector<double> short_of(const std::vector<CoreParameter>& parameters, const std::vector<double>& moved,
                             const std::vector<double>& noise_sigmas) {
  std::vector<double> out(parameters.size(), 0);
  for (std::size_t i = 0; i < std::min({out.size(), moved.size(), noise_sigmas.size()}); ++i) {
    const CoreParameter& p = parameters[i];
    if (p.verdict == "fixed") continue;
    const double least = std::min(std::hypot(noise_sigmas[i], moved[i]), p.prior_sigma);
    out[i] = std::copysign(std::sqrt(std::max(0.0, least * least - p.sigma * p.sigma)), moved[i]);
  }
  return out;
}

}  // namespace

double beyond_chance(double d, double s) {
  const double left = d * d - (s > 0 ? s * s : 0);
  return left > 0 ? std::copysign(std::sqrt(left), d) : 0;
}

const Suspect* most_moving(const std::vector<Suspect>& suspects) {
  const Suspect* out = nullptr;
  for (const Suspect& s : suspects)
    if (s.certain && (!out || s.bias_sigmas > out->bias_sigmas)) out = &s;
  return out;
}

bool explains_more(const std::vector<Suspect>& missing, const Suspect& step) {
  return !missing.empty() && missing.front().certain && missing.front().statistic > step.statistic;
}

void find_largest(const std::vector<CoreParameter>& parameters, const Eigen::VectorXd& moved,
                  const std::function<bool(const CoreParameter&)>& counts, Suspect* out) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(moved.size()); ++i) {
    const CoreParameter& p = parameters[i];
    const double move = moved(static_cast<Eigen::Index>(i)), sigmas = std::abs(move) / p.sigma;
    if (p.verdict == "fixed" || sigmas <= out->bias_sigmas || !counts(p)) continue;
    out->bias_sigmas = sigmas;
    out->moves = p.name;
    out->move = move;
  }
}

void widen_by(Suspect& suspect, ReplayResult* out) {
  std::vector<CoreParameter>& parameters = out->result.parameters;
  std::vector<double>& covariance = out->result.covariance;
  const std::size_t n = parameters.size();
  const double observed_below = SEGCAL_NS::ReleaseRules<double>().observed;
  const std::vector<double> e = short_of(parameters, suspect.moved, out->health.noise_sigmas);
  for (std::size_t i = 0; i < n; ++i) {
    CoreParameter& p = parameters[i];
    p.sigma = std::hypot(p.sigma, e[i]);
    if (p.verdict != "fixed" && p.sigma > observed_below * p.prior_sigma) p.verdict = "weak";
    for (std::size_t j = 0; j < n && covariance.size() == n * n; ++j) covariance[i * n + j] += e[i] * e[j];
  }
  suspect.in_sigmas = !suspect.moved.empty();
}

}  // namespace host::review
