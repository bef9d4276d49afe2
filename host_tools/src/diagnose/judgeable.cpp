#include "diagnose/judgeable.h"

#include <map>

#include "diagnose/hypotheses.h"

namespace host::diagnosis {
namespace {

constexpr std::size_t kFewestSegments = 4;

/// A model that is so wrong that odometry diverges leaves nothing to be fitted. Says so; empty: it does not diverge.
std::string lost_odometry(const ReplayResult& fit) {
  std::map<std::string, std::uint32_t> count;
  for (const auto& [name, n] : fit.counters) count[name] = n;
  const std::uint32_t offered = fit.health.frames_offered;  // every third image of a camera with 30 Hz
  const bool used = 2 * count["frames_used"] > offered, seen = 2 * count["frames_few_tracks"] < count["frames"];
  if (used || !seen || (count["filter_restarts"] == 0 && count["frames_used"] > 0)) return "";
  return "odometry diverges with this model: " + std::to_string(count["filter_restarts"]) + " restarts, " +
         std::to_string(count["frames_used"]) + " of " + std::to_string(offered) +
         " images used; look for something large: the lens model, the resolution that the calibration was made at, the "
         "extrinsics";
}

}  // namespace

bool judgeable(const Problem& plain, const std::vector<Candidate>& candidates, const ReplayResult& fit,
               Diagnosis* out) {
  const std::size_t n = fit.kept.size();
  int seen = 0;
  if (n >= kFewestSegments) {
    for (const Candidate& c : candidates) seen += test_effect(plain, c, {}).seen > 0 ? 1 : 0;
  }
  out->judged = seen > 2;
  out->lost = lost_odometry(fit);
  if (!out->lost.empty()) {
    out->judged = true;
    return false;
  }
  if (n < kFewestSegments) {
    out->sentence = "too short or too still to judge: " + std::to_string(n) +
                    " informative segments of 4 s, at least " + std::to_string(kFewestSegments) +
                    " are needed; move the device about and along all axes for 20 s or more";
  } else if (!out->judged) {
    out->sentence = "too still to judge: " + std::to_string(seen) + " of " + std::to_string(candidates.size()) +
                    " effects would have shown; needs " + needs("");
  }
  return out->judged;
}

}  // namespace host::diagnosis
