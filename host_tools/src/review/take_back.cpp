#include "review/take_back.h"

#include <algorithm>
#include <cmath>

#include "formatted.h"
#include "review/suspected_moves.h"

namespace host::review {
namespace {

/// By how many of its sigmas a suspect moves the value that it moves most; 0: not released, or not known.
double bias_in(const ReplayResult& result, const Suspect& suspect) {
  for (const CoreParameter& p : result.result.parameters)
    if (p.name == suspect.moves && p.verdict != "fixed") return std::abs(suspect.move) / p.sigma;
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
  const std::size_t found = kept.size();
  for (Suspect s : earlier.health.suspects) {
    const auto same = [&s](const Suspect& other) { return other.name == s.name; };
    if (std::any_of(kept.begin(), kept.end(), same)) continue;
    s.in_sigmas = false;
    if (s.name.rfind("bias_step.", 0) == 0) {
      s.move = 0;
      s.moved.clear();
    }
    if (const double bias_sigmas = bias_in(*now, s); bias_sigmas > 0) {
      s.bias_sigmas = bias_sigmas;
      s.words += formatted(" (by the noise that was stated; %.1f sigma by what tracks show)", bias_sigmas);
    }
    kept.push_back(s);
    if (now->result.status == "calibrated" && !s.moved.empty() && s.bias_sigmas > kMostBias)
      take_back("failed", s.words, now);
  }
  if (now->result.status != "calibrated") return;
  for (std::size_t i = found; i < kept.size(); ++i) widen_by(kept[i], now);
}

}  // namespace host::review
