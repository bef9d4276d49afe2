#include "review/widened_sigmas.h"

#include <algorithm>
#include <cmath>

#include "information/release_rules.h"
#include "review/linearised.h"
#include "review/one_segment.h"
#include "review/segment_scatter.h"
#include "review/start_conflict.h"

namespace host::review {
namespace {

constexpr SEGCAL_NS::ReleaseRules<double> kRelease;

/// Correlations stay.
void scale_covariance(std::size_t i, double factor, CoreResult* result) {
  std::vector<double>& covariance = result->covariance;
  const std::size_t n = result->parameters.size();
  if (covariance.size() != n * n) return;
  for (std::size_t j = 0; j < n; ++j) {
    covariance[i * n + j] *= factor;
    covariance[j * n + i] *= factor;
  }
}

/// Nothing changes for a value that is not released.
void widen(std::size_t i, double factor, double most, CoreResult* result) {
  CoreParameter& p = result->parameters[i];
  if (p.verdict == "fixed") return;
  const double before = p.sigma;
  p.sigma = std::max(before, std::min(most, p.sigma * factor));
  if (p.sigma > before) scale_covariance(i, p.sigma / before, result);
  if (p.sigma > kRelease.observed * p.prior_sigma) p.verdict = "weak";
}

}  // namespace

std::vector<Note> widen_sigmas(Core& core, ReplayResult* out) {
  CoreResult& result = out->result;
  for (const CoreParameter& p : result.parameters) out->health.noise_sigmas.push_back(p.sigma);
  const diagnosis::Problem problem = linearised(core, *out, {});
  const double dispersion = result.noise_scale * result.noise_scale;
  const Eigen::MatrixXd printed = printed_by_columns(result.parameters);
  const SegmentScatter scatter = scatter_of_segments(problem, printed, dispersion);
  out->health.segment_scatter = scatter.pooled * dispersion;
  Eigen::VectorXd variance_factor = scatter.variance_factor;
  std::vector<Note> notes;
  if (result.epochs.empty()) {
    const OneSegment one = rests_on_one_segment(problem, printed);
    variance_factor = variance_factor.cwiseMax(one.variance_factor);
    if (const auto note = note_on_one_segment(one, result.parameters)) notes.push_back(*note);
  }
  // The start is what is known at least, where it is not contradicted.
  for (std::size_t i = 0; i < result.parameters.size(); ++i)
    widen(i, std::sqrt(variance_factor(static_cast<Eigen::Index>(i))), result.parameters[i].prior_sigma, &result);
  const std::vector<double> conflict = start_conflict_factors(result.parameters);
  for (std::size_t i = 0; i < conflict.size(); ++i)
    widen(i, conflict[i], conflict[i] * result.parameters[i].sigma, &result);
  if (const auto note = note_on_start_conflict(result.parameters, conflict)) notes.push_back(*note);
  return notes;
}

}  // namespace host::review
