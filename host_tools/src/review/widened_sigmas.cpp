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

/// The start is what is known at least. Nothing changes for a value that is not released.
void widen(std::size_t i, double factor, CoreResult* result) {
  CoreParameter& p = result->parameters[i];
  if (p.verdict == "fixed") return;
  const double before = p.sigma;
  p.sigma = std::min(p.prior_sigma, p.sigma * factor);
  if (p.sigma > before) scale_covariance(i, p.sigma / before, result);
  if (p.sigma > kRelease.observed * p.prior_sigma) p.verdict = "weak";
}

}  // namespace

std::vector<Note> widen_sigmas(Core& core, ReplayResult* out) {
  std::vector<Note> notes;
  CoreResult& result = out->result;
  const std::size_t count = result.parameters.size();
  const auto n = static_cast<Eigen::Index>(count);
  for (const CoreParameter& p : result.parameters) out->health.noise_sigmas.push_back(p.sigma);
  const diagnosis::Problem problem = linearised(core, *out, {});
  const double dispersion = result.noise_scale * result.noise_scale;
  const Eigen::MatrixXd printed = printed_by_columns(result.parameters);
  const SegmentScatter scatter = scatter_of_segments(problem, printed, dispersion);
  out->health.segment_scatter = scatter.pooled * dispersion;
  const Eigen::MatrixXd covariance = Eigen::Map<const Eigen::MatrixXd>(result.covariance.data(), n, n) / dispersion;
  const OneSegment one = rests_on_one_segment(problem.pieces, printed, covariance);
  if (const auto note = note_on_one_segment(one, result.parameters)) notes.push_back(*note);
  const Eigen::VectorXd step = steps_in_their_sigmas(result.parameters, out->health.noise_sigmas);
  std::vector<double> conflict(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    widen(i, std::sqrt(std::max(scatter.variance_factor(at), one.variance_factor(at))), &result);
    conflict[i] = start_conflict_factor(result.parameters[i], step(at));
    widen(i, conflict[i], &result);
  }
  if (const auto note = note_on_start_conflict(result.parameters, conflict)) notes.push_back(*note);
  return notes;
}

}  // namespace host::review
