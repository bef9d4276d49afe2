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

/// Only the earlier replay was sure of an effect that both show.
void make_certain(const Suspect& earlier, Suspect* too, ReplayResult* now) {
  too->certain = true;
  too->words = earlier.words;
  if (now->result.status == "calibrated" && too->bias_sigmas > kMostBias) take_back("failed", too->words, now);
}

}  // namespace

void take_back(const char* status, const std::string& why, ReplayResult* out) {
  out->result.status = status;
  out->calibration = out->start;
  out->cause = why;
}

void refuse_unobserved(ReplayResult* out) {
  const std::vector<CoreParameter>& parameters = out->result.parameters;
  const auto observed = std::count_if(parameters.begin(), parameters.end(),
                                      [](const CoreParameter& p) { return p.verdict == "observed"; });
  if (2 * static_cast<std::size_t>(observed) >= parameters.size()) return;
  const std::string observed_of =
      formatted("%d of %zu parameters are observed", static_cast<int>(observed), parameters.size());
  const std::vector<Suspect>& all = out->health.suspects;
  const auto suspect = std::find_if(all.begin(), all.end(), [](const Suspect& s) { return s.in_sigmas; });
  const std::string held = suspect == all.end() ? "that" : "that, and what " + suspect->name + " would move,";
  const std::vector<Note>& notes = out->health.notes;
  const auto one = std::find_if(notes.begin(), notes.end(), [](const Note& n) { return n.name == "one_segment"; });
  std::string why = formatted("the segments disagree with each other by %.1f times their noise",
                              std::sqrt(out->health.segment_scatter));
  if (one != notes.end()) why += ", and " + one->words;
  take_back("insufficient", why + formatted("; with %s in the sigmas, %s", held.c_str(), observed_of.c_str()), out);
}

void keep_suspects(const ReplayResult& earlier, ReplayResult* now) {
  std::vector<Suspect>& kept = now->health.suspects;
  const std::size_t found = kept.size();
  for (Suspect s : earlier.health.suspects) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&s](const Suspect& o) { return o.name == s.name; });
    if (same != kept.end()) {
      if (s.certain && !same->certain) make_certain(s, &*same, now);
      continue;
    }
    s.in_sigmas = false;
    if (s.name.rfind("bias_step.", 0) == 0 || s.name.rfind("calibration_shift.", 0) == 0) {
      s.move = 0;
      s.moved.clear();
    }
    if (const double bias_sigmas = bias_in(*now, s); bias_sigmas > 0) {
      s.bias_sigmas = bias_sigmas;
      s.words += formatted(" (by the noise that was stated; %.1f sigma by what tracks show)", bias_sigmas);
    }
    kept.push_back(s);
    if (now->result.status == "calibrated" && s.certain && !s.moved.empty() && s.bias_sigmas > kMostBias)
      take_back("failed", s.words, now);
  }
  if (now->result.status != "calibrated") return;
  for (std::size_t i = found; i < kept.size(); ++i) widen_by(kept[i], now);
  refuse_unobserved(now);
}

}  // namespace host::review
