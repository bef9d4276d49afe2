// What the data still call for beside the effects that were accepted.
#include "diagnose/selection.h"

namespace host::diagnosis {

void Leftover::take(double fall, const std::string& name) {
  if (fall <= chi2) return;
  chi2 = fall;
  what = name;
}

Leftover leftover_of(const Selection& selection) {
  std::vector<TermGroup> free;
  std::vector<bool> asked;  // of a step that was dropped the columns are gone
  for (std::size_t i = 0; i < selection.alone.size(); ++i) {
    asked.push_back(selection.alone[i].seen > 0 && selection.candidates[i].kind != Kind::step);
  }
  for (const Accepted& a : selection.accepted) {
    free.push_back(selection.candidates[a.candidate].columns);
    if (static_cast<std::size_t>(a.candidate) < asked.size()) asked[a.candidate] = false;
  }
  Leftover out;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (!asked[i]) continue;
    const EffectTest test = judge_effect(selection.problem, selection.candidates[i], free);
    if (test.seen > 0 && called(test.log10_p, selection.candidates[i].share))
      out.take(test.chi2, selection.candidates[i].name);
  }
  return out;
}

}  // namespace host::diagnosis
