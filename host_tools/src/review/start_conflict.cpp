#include "review/start_conflict.h"

#include <algorithm>
#include <cmath>

#include "formatted.h"
#include "information/release_rules.h"
#include "review/linearised.h"
#include "review/names.h"

namespace host::review {
namespace {

constexpr double kMostStep = 3;  ///< chance makes one such step in 2000, as it has 0.87 of the start's sigma at most

}  // namespace

std::vector<double> start_conflict_factors(const std::vector<CoreParameter>& parameters) {
  const Eigen::VectorXd step = printed_by_columns(parameters) * step_from_start(parameters);
  const double weak = SEGCAL_NS::ReleaseRules<double>().weak;
  std::vector<double> out(parameters.size(), 1);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const CoreParameter& p = parameters[i];
    const double sigmas = std::abs(step(static_cast<Eigen::Index>(i))) / p.prior_sigma;
    if (p.verdict == "weak" && p.sigma >= weak * p.prior_sigma && sigmas > kMostStep) out[i] = sigmas;
  }
  return out;
}

std::optional<Note> note_on_start_conflict(const std::vector<CoreParameter>& parameters,
                                           const std::vector<double>& factors) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    if (factors[i] > 1) names.push_back(parameters[i].name);
  }
  if (names.empty()) return std::nullopt;
  const auto most = std::max_element(factors.begin(), factors.end());
  const CoreParameter& p = parameters[static_cast<std::size_t>(most - factors.begin())];
  return Note{"start_conflict", *most,
              formatted("the recording tells little more of %s than the start, and contradicts it (%s went from %.4g "
                        "to %.4g, by %.1f of its start's sigmas): one of the two is wrong, and sigma is as large as "
                        "they are apart. Measure it, or record more motion that shows it",
                        names_of(names).c_str(), p.name.c_str(), p.initial, p.value, *most)};
}

}  // namespace host::review
