// The problem that a replay's last calibration solved: what was kept, in its order, with its links.
#include <algorithm>
#include <cmath>

#include "replay/kept_segments.h"
#include "replay/words.h"

namespace host {
namespace {

/// The database may have changed since the calibration whose links these are: what a segment hung on may be gone, and
/// another one may stand in its place. A link holds if the segment before still ends `gap_s` before this one begins;
/// the core has that as a float, and stamps in us.
bool hangs_on(const CoreKept& before, const CoreKept& k) {
  if (before.keyframes.empty() || k.keyframes.empty()) return false;
  const double gap_s = 1e-9 * static_cast<double>(k.keyframes.front().t_ns - before.keyframes.back().t_ns);
  return std::abs(gap_s - k.gap_s) <= 1e-5 + 1e-6 * std::abs(gap_s);
}

}  // namespace

KeptSegments kept_segments(const ReplayResult& result) {
  KeptSegments out;
  out.model = result.model;
  out.start = result.start;
  out.noise = result.noise;
  const CoreResult& r = result.result;
  const double noise = r.noise_scale * r.noise_scale;
  if (r.dof > 0 && noise > 1.0001 * std::max(1.0, r.chi2 / r.dof)) out.scatter = noise;  // the core's floats round
  for (const CoreParameter& p : result.result.parameters) out.prior_sigma.push_back(p.prior_sigma);
  const std::size_t n_theta = std::min(out.prior_sigma.size(), parameter_names(result.start).size());
  for (std::size_t i = n_theta; i < result.result.parameters.size(); ++i)
    out.effects.push_back(result.result.parameters[i].name);
  out.prior_sigma.resize(n_theta);
  for (const CoreEpoch& e : r.epochs) out.condensed += e.segments;
  for (const CoreKept& k : result.kept) {
    if (k.place >= 0) out.segments.push_back(k);
  }
  std::sort(out.segments.begin(), out.segments.end(),
            [](const CoreKept& a, const CoreKept& b) { return a.place < b.place; });
  for (std::size_t i = 0; i < out.segments.size(); ++i) {
    if (i == 0 || !hangs_on(out.segments[i - 1], out.segments[i])) out.segments[i].join = "none";
  }
  return out;
}

}  // namespace host
