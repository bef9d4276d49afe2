#include "diagnose/rivals.h"

#include <algorithm>
#include <cmath>

#include "diagnose/shift.h"

namespace host::diagnosis {

int dominant_of(const Problem& problem, const std::vector<Candidate>& candidates, const std::vector<TermGroup>& free,
                const std::vector<int>& open) {
  int best = -1;
  double most = 0, next = 0;
  for (int c : open) {
    const EffectTest test = test_effect(problem, candidates[c], free);
    if (test.seen == 0 || !called(test.log10_p, candidates[c].share)) continue;
    next = std::max(next, std::min(most, test.statistic));
    if (test.statistic <= most) continue;
    most = test.statistic;
    best = c;
  }
  return most > decision::kDominates * next ? best : -1;
}

bool says_more_than(const Shift& step, const std::vector<std::pair<double, int>>& effects, const Problem& problem,
                    const std::vector<Candidate>& candidates, const std::vector<TermGroup>& free) {
  const double share = std::log(share_of(step)), of_step = step.test.log10_p - share / std::log(10.0);
  return std::any_of(effects.begin(), effects.end(), [&](const std::pair<double, int>& effect) {
    if (effect.first <= of_step) return true;
    const Candidate& c = candidates[effect.second];
    const EffectTest test = test_effect(problem, c, free);
    const bool as_significant = test.log10_p - std::log10(c.share) <= of_step,
               likelier = test.log_evidence + std::log(c.share) >= step.test.log_evidence + share;
    return (as_significant || likelier) && halves_refuse(problem, c, free).empty();
  });
}

std::vector<int> rivals_of(const Problem& problem, const std::vector<Candidate>& candidates, int accepted,
                           const std::vector<TermGroup>& others, const std::vector<int>& open) {
  std::vector<int> out;
  const EffectTest as_it_is = test_effect(problem, candidates[accepted], others);
  for (int b : open) {
    if (candidates[b].kind == Kind::term) continue;
    const EffectTest instead = test_effect(problem, candidates[b], others);
    if (instead.seen == 0 || !called(instead.log10_p, candidates[b].share)) continue;
    std::vector<TermGroup> with_b = others;
    with_b.push_back(candidates[b].columns);
    const EffectTest beside = test_effect(problem, candidates[accepted], with_b);
    // Two log likelihoods apart per degree of freedom is what chance gives between models that fit equally well.
    const double apart = as_it_is.statistic - instead.statistic - 2 * (as_it_is.seen - instead.seen);
    if (beside.log10_p > decision::kLog10AddsNothing && apart < decision::kFitsAlike) out.push_back(b);
  }
  return out;
}

}  // namespace host::diagnosis
