#include "diagnose/beyond.h"

#include <algorithm>
#include <cmath>

#include "diagnose/answer.h"
#include "diagnose/shift.h"
#include "segcal/config.h"

namespace host::diagnosis {
namespace {

constexpr std::size_t kBatch = 30;  ///< columns of one linearisation beside those that are estimated

}  // namespace

Beyond::Beyond(Evidence* evidence, std::vector<TermInfo>* terms, std::vector<double>* start, Selection* selection,
               Budget* work, bool has_temperature)
    : work_(work),
      evidence_(evidence),
      terms_(terms),
      start_(start),
      selection_(selection),
      dictionary_(dictionary(has_temperature)) {}

void Beyond::run(const Fit& fit) {
  std::vector<Open> open = scan();
  for (int i = 0; i < decision::kTermRounds && !selection_->shifted; ++i) {  // fits do not know steps
    const std::vector<TermInfo> best = best_that_hold(open);
    if (best.empty() || !work_->allows_fit()) break;
    for (const TermInfo& term : best) add(term);
    refit(fit);
    drop_superfluous(fit);
    open = scan();
    selection_->leftover = leftover_of(*selection_);
  }
  for (const Open& o : open) selection_->leftover.take(o.chi2, in_words(o.term.term));
}

double Beyond::share() const { return share_of(Kind::term) / static_cast<double>(dictionary_.size()); }

/// Terms that are significant beside what was accepted, at the last fit, the most significant first.
std::vector<Beyond::Open> Beyond::scan() {
  std::vector<Open> out;
  const auto size = static_cast<double>(dictionary_.size());
  for (std::size_t from = 0; from < dictionary_.size(); from += kBatch) {
    const std::size_t to = std::min(from + kBatch, dictionary_.size());
    const std::vector<TermInfo> batch(dictionary_.begin() + static_cast<std::ptrdiff_t>(from),
                                      dictionary_.begin() + static_cast<std::ptrdiff_t>(to));
    const Problem problem = problem_with(batch, false);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const EffectTest test = test_effect(problem, candidate_at(i, batch[i]), free_in(problem));
      if (test.seen > 0 && called(test.log10_p, decision::kLeftShare / size))
        out.push_back({batch[i], test.chi2, test.log10_p});
    }
  }
  std::sort(out.begin(), out.end(), [](const Open& a, const Open& b) { return a.log10_p < b.log10_p; });
  return out;
}

/// The best term of each axis of a sensor, of the few that are asked.
/// What an effect leaks into other axes goes again when it is in the fit.
std::vector<TermInfo> Beyond::best_that_hold(const std::vector<Open>& open) {
  std::vector<TermInfo> out;
  int asked = 0;
  for (const Open& o : open) {
    if (!called(o.log10_p, share()) || asked == decision::kTermsAsked) break;
    if (std::any_of(out.begin(), out.end(), [&o](const TermInfo& t) { return t.term.kind == o.term.term.kind; }))
      continue;
    ++asked;
    const Problem problem = problem_with({o.term}, true);
    if (holds(problem, candidate_at(0, o.term))) out.push_back(o.term);
  }
  return out;
}

/// As for an effect of the catalogue: significant against its own
/// scatter, the same in both halves, and of use to the other.
bool Beyond::holds(const Problem& problem, const Candidate& candidate) const {
  const std::vector<TermGroup> free = free_in(problem);
  return called(judge_effect(problem, candidate, free).log10_p, share()) &&
         halves_refuse(problem, candidate, free).empty();
}

/// Columns [theta | taken | candidates | step].
Problem Beyond::problem_with(const std::vector<TermInfo>& candidates, bool in_parts) {
  Problem out = evidence_->at_last_fit(candidates, in_parts || selection_->shifted);
  out.noise = selection_->problem.noise;
  return selection_->shifted ? with_shift(out, selection_->shift) : out;
}

Candidate Beyond::candidate_at(std::size_t i, const TermInfo& term) const {
  return {kUnlisted, {static_cast<int>(evidence_->taken().size() + i), 1}, {term.size}, share(), Kind::term};
}

/// What was accepted.
std::vector<TermGroup> Beyond::free_in(const Problem& problem) const {
  const int n = static_cast<int>(evidence_->taken().size());
  std::vector<TermGroup> out;
  if (n > 0) out.push_back({0, n});
  if (selection_->shifted) out.push_back(shift_candidate(problem, selection_->shift).columns);
  return out;
}

void Beyond::add(const TermInfo& term) {
  dictionary_.erase(std::find_if(dictionary_.begin(), dictionary_.end(), [&term](const TermInfo& t) {
    return t.term.kind == term.term.kind && t.term.a == term.term.a && t.term.b == term.term.b &&
           t.term.c == term.term.c;
  }));
  selection_->candidates.push_back(
      {kUnlisted, {static_cast<int>(terms_->size()), 1}, {term.size}, share(), Kind::term});
  terms_->push_back(term);
  start_->push_back(0);
  selection_->accepted.push_back({static_cast<int>(selection_->candidates.size()) - 1, {}});
}

void Beyond::refit(const Fit& fit) {
  std::vector<bool> estimated(terms_->size(), false);
  for (const Accepted& a : selection_->accepted) {
    const TermGroup& g = selection_->candidates[a.candidate].columns;
    for (int i = 0; i < g.count; ++i) estimated[g.first + i] = true;
  }
  selection_->problem = fit(estimated);
  for (std::size_t i = 0; i < selection_->accepted.size(); ++i) {
    Accepted& a = selection_->accepted[i];
    a.test = judge_effect(selection_->problem, selection_->candidates[a.candidate], groups_but(i));
  }
}

std::vector<TermGroup> Beyond::groups_but(std::size_t left_out) const {
  std::vector<TermGroup> out;
  for (std::size_t i = 0; i < selection_->accepted.size(); ++i) {
    if (i != left_out) out.push_back(selection_->candidates[selection_->accepted[i].candidate].columns);
  }
  return out;
}

/// An effect of the catalogue that was only a likeness of a new term, or a term that was one of another.
void Beyond::drop_superfluous(const Fit& fit) {
  for (std::size_t i = 0; i < selection_->accepted.size(); ++i) {
    const Accepted a = selection_->accepted[i];
    if (a.test.seen > 0 && called(a.test.log10_p, selection_->candidates[a.candidate].share)) continue;
    selection_->rejected.push_back({a.candidate, "a term that the catalogue has not says more"});
    selection_->accepted.erase(selection_->accepted.begin() + static_cast<std::ptrdiff_t>(i));
    refit(fit);
    return drop_superfluous(fit);
  }
}

}  // namespace host::diagnosis
