#include "diagnose/searched_model.h"

#include <algorithm>

#include "diagnose/exposure_offset.h"
#include "sensors/effect_terms.h"

namespace host::diagnosis {

CoreOptions without_effects(CoreOptions core, bool has_temperature) {
  core.has_temperature = has_temperature;
  core.effects = 0;
  core.terms.clear();
  core.term_values.clear();
  return core;
}

SearchedModel::SearchedModel(const CoreOptions& given, bool has_temperature, bool has_exposures) {
  Catalogue catalogue = core_catalogue(has_temperature);
  terms = std::move(catalogue.terms);
  candidates = std::move(catalogue.candidates);
  start.assign(terms.size(), 0);
  begin_with(given);
  if (has_exposures) add_exposure_offset(this);
  given_terms_ = terms.size();
}

void SearchedModel::begin_with(const CoreOptions& given) {
  std::size_t next = 0;
  const std::vector<double>& values = given.term_values;
  const auto take = [this, &next, &values](std::size_t candidate) {
    const TermGroup& g = candidates[candidate].columns;
    known.push_back(static_cast<int>(candidate));
    for (int i = 0; i < g.count; ++i) start[g.first + i] = next < values.size() ? values[next++] : 0;
  };
  const std::size_t listed = candidates.size();
  for (std::size_t c = 0; c < listed; ++c) {
    if ((given.effects >> terms[candidates[c].columns.first].bit & 1u) != 0) take(c);
  }
  for (const CoreTerm& term : given.terms) {
    terms.push_back(term_info(term));
    candidates.push_back({kUnlisted, {static_cast<int>(terms.size()) - 1, 1}, {terms.back().size}, 1, Kind::term});
    start.push_back(0);
    take(candidates.size() - 1);
  }
}

void SearchedModel::include(const Told& told) {
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const int candidate = static_cast<int>(c);
    if (!told.has(candidates[c].name)) continue;
    if (std::count(known.begin(), known.end(), candidate) == 0) known.push_back(candidate);
    if (candidates[c].name != "rolling_shutter") continue;
    needed.push_back(candidate);
    double& value = start[candidates[c].columns.first];
    if (value == 0) value = told.line_delay;  // a model's is nearer
  }
}

void SearchedModel::forget_additions() {
  terms.resize(given_terms_);
  start.resize(given_terms_);
}

void SearchedModel::begin_at(const Problem& last, const std::vector<int>& accepted) {
  std::vector<TermGroup> groups;
  groups.reserve(accepted.size());
  for (int c : accepted) groups.push_back(candidates[c].columns);
  const Solution s = solve(with_groups(with_prior(last.all, last.prior), last.n_theta, groups));
  int at = last.n_theta;
  for (const TermGroup& g : groups) {
    for (int i = 0; i < g.count; ++i) {
      const double most = 3 * terms[g.first + i].size;
      start[g.first + i] = std::clamp(s.x(at++), -most, most);
    }
  }
}

std::vector<bool> SearchedModel::columns_of(const std::vector<int>& accepted) const {
  std::vector<bool> out(terms.size(), false);
  for (int c : accepted) {
    for (int i = 0; i < candidates[c].columns.count; ++i) out[candidates[c].columns.first + i] = true;
  }
  return out;
}

bool SearchedModel::lens_has_no_name(const Selection& selection) const {
  return std::any_of(selection.accepted.begin(), selection.accepted.end(), [this, &selection](const Accepted& a) {
    const Candidate& c = selection.candidates[a.candidate];
    return c.kind == Kind::term && terms[c.columns.first].term.kind >= static_cast<int>(SEGCAL_NS::TermKind::image_u);
  });
}

}  // namespace host::diagnosis
