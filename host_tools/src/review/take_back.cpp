#include "review/take_back.h"

#include <algorithm>

#include "formatted.h"

namespace host::review {
namespace {

/// 0: not released.
double sigma_of(const std::string& name, const ReplayResult& result) {
  for (const CoreParameter& p : result.result.parameters)
    if (p.name == name && p.verdict != "fixed") return p.sigma;
  return 0;
}

}  // namespace

void take_back(const char* status, const std::string& why, ReplayResult* out) {
  out->result.status = status;
  out->calibration = out->start;
  out->cause = why;
}

void keep_suspects(const ReplayResult& earlier, ReplayResult* now) {
  std::vector<Suspect>& kept = now->health.suspects;
  for (Suspect s : earlier.health.suspects) {
    const auto same = [&s](const Suspect& other) { return other.name == s.name; };
    if (std::any_of(kept.begin(), kept.end(), same)) continue;
    const double before = sigma_of(s.moves, earlier), sigma = sigma_of(s.moves, *now);
    const bool is_step = s.name.rfind("bias_step.", 0) == 0;
    if (!is_step && before > 0 && sigma > 0) {
      s.bias_sigmas *= before / sigma;
      s.words += formatted(" (by the noise that was stated; %.1f sigma by what tracks show)", s.bias_sigmas);
    }
    kept.push_back(s);
    if (!is_step && now->result.status == "calibrated" && s.bias_sigmas > kMostBias) take_back("failed", s.words, now);
  }
}

}  // namespace host::review
