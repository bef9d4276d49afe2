#include "review/start_conflict.h"

#include <algorithm>
#include <cmath>

#include "formatted.h"
#include "review/linearised.h"

namespace host::review {
namespace {

constexpr double kMostStep =
    3;  ///< chance makes one of 370 weak values look like that, and a larger sigma harms little

}  // namespace

Eigen::VectorXd steps_in_their_sigmas(const std::vector<CoreParameter>& parameters,
                                      const std::vector<double>& noise_sigmas) {
  Eigen::VectorXd step = printed_by_columns(parameters) * step_from_start(parameters);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const CoreParameter& p = parameters[i];
    const double variance = p.prior_sigma * p.prior_sigma - noise_sigmas[i] * noise_sigmas[i];
    double& of_step = step(static_cast<Eigen::Index>(i));
    of_step = p.verdict == "fixed" || variance <= 0 ? 0 : std::abs(of_step) / std::sqrt(variance);
  }
  return step;
}

double start_conflict_factor(const CoreParameter& parameter, double step_in_its_sigmas) {
  return parameter.verdict == "weak" && step_in_its_sigmas > kMostStep ? step_in_its_sigmas : 1;
}

std::optional<Note> note_on_start_conflict(const std::vector<CoreParameter>& parameters,
                                           const std::vector<double>& factors) {
  const auto most = std::max_element(factors.begin(), factors.end());
  if (most == factors.end() || *most <= 1) return std::nullopt;
  const CoreParameter& p = parameters[static_cast<std::size_t>(most - factors.begin())];
  return Note{
      "start_conflict", *most,
      formatted("%s went from %.4g to %.4g, %.1f times as far as its start's sigma of %.2g lets expect, and the "
                "recording tells little more of it than the start: one of both is wrong, and its sigma holds "
                "that. Measure it, or record more motion that shows it",
                p.name.c_str(), p.initial, p.value, *most, p.prior_sigma)};
}

}  // namespace host::review
