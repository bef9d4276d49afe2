#include "review/suspected_moves.h"

#include <algorithm>
#include <cmath>

#include "information/release_rules.h"

namespace host::review {
namespace {

/// By parameter, 0 where it is fixed; not farther than where its sigma would be the prior's.
std::vector<double> moves_of(const Suspect& suspect, const std::vector<CoreParameter>& parameters) {
  std::vector<double> out(parameters.size(), 0);
  for (std::size_t i = 0; i < std::min(out.size(), suspect.moved.size()); ++i) {
    const CoreParameter& p = parameters[i];
    const double most = std::sqrt(std::max(0.0, p.prior_sigma * p.prior_sigma - p.sigma * p.sigma));
    if (p.verdict != "fixed") out[i] = std::clamp(suspect.moved[i], -most, most);
  }
  return out;
}

}  // namespace

void widen_by(Suspect& suspect, ReplayResult* out) {
  std::vector<CoreParameter>& parameters = out->result.parameters;
  std::vector<double>& covariance = out->result.covariance;
  const std::size_t n = parameters.size();
  const double observed_below = SEGCAL_NS::ReleaseRules<double>().observed;
  const std::vector<double> d = moves_of(suspect, parameters);
  for (std::size_t i = 0; i < n; ++i) {
    CoreParameter& p = parameters[i];
    p.sigma = std::hypot(p.sigma, d[i]);
    if (p.verdict != "fixed" && p.sigma > observed_below * p.prior_sigma) p.verdict = "weak";
    for (std::size_t j = 0; j < n && covariance.size() == n * n; ++j) covariance[i * n + j] += d[i] * d[j];
  }
  suspect.in_sigmas = !suspect.moved.empty();
}

}  // namespace host::review
