#include "diagnose/candidates_report.h"

namespace host::diagnosis {

void report_candidates(const Selection& selection, bool has_temperature, bool has_exposures, Diagnosis* out) {
  const auto name_of = [&selection](int candidate) { return selection.candidates[candidate].name; };
  for (const Rejected& r : selection.rejected) out->rejected.push_back({name_of(r.candidate), r.why});
  for (int c : selection.cannot_tell) out->cannot_tell.push_back({name_of(c), "needs " + needs(name_of(c))});
  for (const Hypothesis& h : hypotheses()) {
    if ((h.asks == Asks::temperature && !has_temperature) || (h.asks == Asks::exposures && !has_exposures))
      out->cannot_tell.push_back({h.name, std::string("needs ") + h.needs});
  }
  for (std::size_t i = 0; i < selection.alone.size(); ++i) {
    const EffectTest& t = selection.alone[i];
    out->scores.push_back({selection.candidates[i].name, t.statistic, t.log10_p, t.seen});
  }
}

}  // namespace host::diagnosis
