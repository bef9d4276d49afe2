#include "replay/passes.h"

#include <cmath>
#include <cstdio>

namespace host {

void measure_step(const CoreResult& now, const CoreResult* before, ReplayPass* pass) {
  for (std::size_t i = 0; i < now.parameters.size(); ++i) {
    const CoreParameter& p = now.parameters[i];
    const double from = before && i < before->parameters.size() ? before->parameters[i].value : p.initial;
    if (!(p.sigma > 0) || p.value == from) continue;
    const double step = std::abs(p.value - from) / p.sigma;
    if (step <= pass->step_sigmas) continue;
    pass->step_sigmas = step;
    pass->moved = p.name;
  }
}

std::string in_words(const ReplayPass& pass, std::size_t number) {
  char text[300];
  std::snprintf(
      text, sizeof text,
      "pass %zu: %s, %d of %d segments, %u images used, %u restarts, chi2/dof %.3f, largest step %.2f sigma%s%s%s",
      number, pass.status.c_str(), pass.segments, pass.segments_scored, pass.frames_used, pass.filter_restarts,
      pass.chi2_per_dof, pass.step_sigmas, pass.moved.empty() ? "" : " (", pass.moved.c_str(),
      pass.moved.empty() ? "" : ")");
  return text;
}

}  // namespace host
