#include "review/joint_filter.h"

#include <algorithm>
#include <cmath>

#include "compare/parameters.h"
#include "formatted.h"
#include "information/release_rules.h"
#include "review/take_back.h"

namespace host::review {
namespace {

ParameterList listed(const CoreResult& result) {
  ParameterList out;
  for (const CoreParameter& p : result.parameters) out.push_back({p.name, p.unit, p.value, p.sigma, p.verdict});
  return out;
}

}  // namespace

std::string against_joint_filter(const CoreResult& filter, const CoreResult& segments) {
  constexpr double kMostSquare = 1.5, kMostSigmas = 3.5;
  const std::vector<ParameterDifference> all = differences(listed(filter), listed(segments));
  double sum = 0, largest = 0;
  int values = 0;
  std::string farthest;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (filter.parameters[i].verdict == "fixed" || segments.parameters[i].verdict == "fixed") continue;
    const double off = std::abs(*all[i].in_difference);
    sum += off * off;
    ++values;
    if (off < largest) continue;
    largest = off;
    farthest = all[i].name;
  }
  if (values == 0 || (sum <= kMostSquare * values && largest <= kMostSigmas)) return "";
  return formatted(
      "the filter's calibration is not where its sigmas say: %s is %.1f sigma from the calibration by segments, the "
      "mean square over %d values is %.1f (1 at most where both are right). Replay without --joint-ekf",
      farthest.c_str(), largest, values, sum / values);
}

void claim_no_more(const CoreResult& segments, CoreResult* filter) {
  std::vector<CoreParameter>& parameters = filter->parameters;
  const std::size_t n = parameters.size();
  const double observed_below = SEGCAL_NS::ReleaseRules<double>().observed;
  std::vector<double> growth(n, 1);
  for (std::size_t i = 0; i < n; ++i) {
    CoreParameter& p = parameters[i];
    if (p.verdict == "fixed") continue;
    const double sigma = std::clamp(segments.parameters.at(i).sigma, p.sigma, std::max(p.sigma, p.prior_sigma));
    growth[i] = sigma / p.sigma;
    p.sigma = sigma;
    if (sigma > observed_below * p.prior_sigma) p.verdict = "weak";
  }
  if (filter->covariance.size() != n * n) return;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) filter->covariance[i * n + j] *= growth[i] * growth[j];
  }
}

void judge_joint_filter(const std::vector<Recording>& sessions, const ReplayOptions& options, ReplayResult* out) {
  if (out->result.status != "calibrated") return;
  ReplayOptions by_segments = options;
  by_segments.joint_ekf = false;
  by_segments.profile = "host";  // of all segments, as the filter has seen them all
  by_segments.core.segments = most_segments("host");
  by_segments.keep_core = nullptr;
  by_segments.after_session = nullptr;
  const ReplayResult segments = replay_as_stated(sessions, by_segments);
  if (segments.result.status != "calibrated") {
    const std::string why = segments.cause.empty() ? segments.result.status : segments.cause;
    return take_back("insufficient", "nothing to hold the filter's calibration against: by segments, " + why, out);
  }
  const std::string against = against_joint_filter(out->result, segments.result);
  if (!against.empty()) return take_back("failed", against, out);
  claim_no_more(segments.result, &out->result);
}

}  // namespace host::review
