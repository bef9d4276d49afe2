#include "diagnose/selection.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "diagnose/chi_square.h"
#include "diagnose/shift.h"

namespace host::diagnosis {
namespace {

/// Share of its statistic by which an effect must lower the held-out cost.
constexpr double kHelps = 0.25;
/// A step of the calibration can fit whatever changes with time, also what another effect leaves: it must say more than this
/// share of what the others do.
constexpr double kStepShare = 0.05;

std::string number(const char* format, double value) {
  char text[80];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

class Search {
 public:
  Search(const std::vector<Candidate>& candidates, const SelectionOptions& options, const Refit& refit)
      : candidates_(candidates), given_(static_cast<int>(candidates.size())), options_(options), refit_(refit), why_(candidates.size()),
        chosen_(options.known) {}

  Selection run() {
    fit_again();
    judge_alone();
    while (static_cast<int>(chosen_.size()) < options_.most && step_forward()) step_back();
    finish();
    return out_;
  }

 private:
  /// Effects that would not have shown are out from the start.
  void judge_alone() {
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      out_.alone.push_back(test_effect(out_.problem, candidates_[i], {}));
      if (out_.alone.back().seen == 0) {
        out_.cannot_tell.push_back(static_cast<int>(i));
      } else {
        tested_ += candidates_[i].handicap == 0 ? 1 : 0;
      }
    }
  }

  std::vector<TermGroup> groups_but(int left_out) const {
    std::vector<TermGroup> out;
    for (int c : chosen_) {
      if (c != left_out) out.push_back(candidates_[c].columns);
    }
    return out;
  }

  bool is_chosen(int c) const { return std::count(chosen_.begin(), chosen_.end(), c) > 0; }
  /// Could be chosen now. The columns of a step that was dropped are no longer in the rows.
  bool open_to(int c) const { return out_.alone[c].seen > 0 && !is_chosen(c) && c < given_; }

  double corrected(int c, const EffectTest& test) const {
    return test.log10_p + std::log10(std::max(1, tested_)) + candidates_[c].handicap;
  }
  static double corrected(const Shift& step) { return step.test.log10_p + std::log10(step.trials); }
  bool significant(int c, const EffectTest& test) const { return test.seen > 0 && corrected(c, test) < options_.log10_level; }

  /// Candidates that are significant with the chosen ones free, the most significant first.
  std::vector<std::pair<double, int>> calls() {
    std::vector<std::pair<double, int>> order;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const int c = static_cast<int>(i);
      if (!open_to(c)) continue;
      EffectTest test = test_effect(out_.problem, candidates_[i], groups_but(-1));
      if (!significant(c, test)) continue;
      calm(c, &test);
      if (significant(c, test)) order.emplace_back(corrected(c, test), c);
    }
    std::sort(order.begin(), order.end());
    return order;
  }

  /// An effect whose value differs from piece to piece by more than its noise is judged against that.
  void calm(int c, EffectTest* test) {
    const Scatter scatter = scatter_over_time(out_.problem, candidates_[c], groups_but(-1));
    if (scatter.dof == 0) return;
    test->log10_p = scatter.log10_p(test->statistic, test->seen);
    test->statistic /= scatter.factor;
    if (!significant(c, *test)) why_[c] = "its value is not the same throughout the recording";
  }

  /// Accepts the most significant candidate that both halves tell of.
  bool step_forward() {
    const std::vector<std::pair<double, int>> order = calls();
    const std::size_t before = chosen_.size();
    offer_shift(order);
    if (chosen_.size() > before) return true;
    for (const auto& [p, c] : order) {
      const HalvesTest halves = test_halves(out_.problem, candidates_[c], groups_but(-1));
      if (halves.log10_p_disagree < options_.log10_disagree) {
        why_[c] = "the halves of the recording disagree about it (p = 1e" + number("%.0f", halves.log10_p_disagree) + ")";
      } else if (!helps(halves, test_effect(out_.problem, candidates_[c], groups_but(-1)))) {
        why_[c] = "its value from one half of the recording does not help the other";
      } else if (dropped_before(c)) {
        why_[c] = "not needed beside the others";
      } else {
        chosen_.push_back(c);
        fit_again();
        return true;
      }
    }
    return false;
  }

  /// The core knows the effects of the catalogue; a step is put on top of what it hands out.
  void fit_again() {
    std::vector<int> known;
    for (int c : chosen_) {
      if (c < given_) known.push_back(c);
    }
    out_.problem = refit_(known);
    if (out_.shifted) out_.problem = with_shift(out_.problem, out_.shift);
  }

  /// A step that says more than every effect becomes one candidate more.
  void offer_shift(const std::vector<std::pair<double, int>>& others) {
    if (out_.shifted || shift_refused_) return;
    const std::optional<Shift> step = best_shift(out_.problem, groups_but(-1));
    if (!step) return;
    const double p = corrected(*step);
    if (p >= options_.log10_level || (!others.empty() && others.front().first <= p)) return;
    if (is_little(step->test)) {
      shift_refused_ = step_was_little_ = true;
      return;
    }
    const Problem without = out_.problem;
    out_.problem = with_shift(without, *step);
    const Candidate candidate = shift_candidate(out_.problem, *step);
    const Scatter scatter = scatter_over_time(out_.problem, candidate, groups_but(-1));
    const HalvesTest halves = test_halves(out_.problem, candidate, groups_but(-1));
    if (calmed(*step, scatter) >= options_.log10_level || halves.log10_p_disagree < options_.log10_disagree || !helps(halves, step->test)) {
      out_.problem = without;
      shift_refused_ = true;
      return;
    }
    out_.shifted = true;
    out_.shift = *step;
    candidates_.push_back(candidate);
    why_.emplace_back();
    out_.alone.push_back(step->test);
    chosen_.push_back(static_cast<int>(candidates_.size()) - 1);
  }

  bool is_little(const EffectTest& step) const {
    double others = 0;
    for (int c : chosen_) {
      if (c < given_) others += test_effect(out_.problem, candidates_[c], groups_but(c)).statistic;
    }
    return step.statistic < kStepShare * others;
  }

  /// The pieces that know a step's size are those after it, often few; the test of F would cost most steps. It is taken where
  /// the scatter is more than chance gives in one of a hundred.
  static double calmed(const Shift& step, const Scatter& scatter) {
    const bool by_chance = log10_upper_tail(scatter.factor * scatter.dof, scatter.dof) > -2;
    const double p = by_chance ? step.test.log10_p : scatter.log10_p(step.test.statistic, step.test.seen);
    return p + std::log10(step.trials);
  }
  static bool helps(const HalvesTest& halves, const EffectTest& test) { return halves.gain > kHelps * test.statistic; }
  bool dropped_before(int c) const { return std::count(dropped_.begin(), dropped_.end(), c) > 0; }

  /// Drops what the newer ones make superfluous.
  void step_back() {
    for (std::size_t i = 0; i + 1 < chosen_.size();) {
      const int c = chosen_[i];
      const bool known = std::count(options_.known.begin(), options_.known.end(), c) > 0;
      const EffectTest beside = test_effect(out_.problem, candidates_[c], groups_but(c));
      if (known || (significant(c, beside) && !(c >= given_ && is_little(beside)))) {
        ++i;
        continue;
      }
      why_[c] = "not needed beside " + candidates_[chosen_.back()].name;
      dropped_.push_back(c);
      chosen_.erase(chosen_.begin() + static_cast<std::ptrdiff_t>(i));
      if (c >= given_) {
        out_.shifted = false;
        shift_refused_ = true;
      }
      fit_again();
      i = 0;
    }
  }

  void finish() {
    out_.candidates = candidates_;
    for (int c : chosen_) out_.accepted.push_back({c, test_effect(out_.problem, candidates_[c], groups_but(c))});
    for (const Accepted& a : out_.accepted) find_rivals(a);
    if (const std::optional<Shift> step = step_was_little_ ? best_shift(out_.problem, groups_but(-1)) : std::nullopt) {
      if (corrected(*step) < options_.log10_level) out_.leftover = step->test.statistic;
    }
    out_.leftover = std::max(out_.leftover, leftover_of(out_, options_));
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const int c = static_cast<int>(i);
      if (!is_chosen(c) && significant(c, out_.alone[i])) out_.rejected.push_back({c, reason(c)});
    }
  }

  std::string reason(int c) const {
    for (const Pair& pair : out_.pairs) {
      if (pair.other == c) return "this motion does not tell it from " + candidates_[pair.accepted].name;
    }
    const bool open = open_to(c) && significant(c, test_effect(out_.problem, candidates_[c], groups_but(-1)));
    if (!why_[c].empty() && (open || dropped_before(c))) return why_[c];
    return chosen_.empty() ? "not significant" : "explained by " + candidates_[chosen_.front()].name;
  }

  /// With the other accepted ones free: B alone explains as much as A, and A adds nothing to B.
  void find_rivals(const Accepted& a) {
    const std::vector<TermGroup> others = groups_but(a.candidate);
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const int b = static_cast<int>(i);
      if (!open_to(b)) continue;
      const EffectTest instead = test_effect(out_.problem, candidates_[i], others);
      std::vector<TermGroup> with_b = others;
      with_b.push_back(candidates_[i].columns);
      const EffectTest beside = test_effect(out_.problem, candidates_[a.candidate], with_b);
      // Two log likelihoods apart per degree of freedom is what chance gives between models that fit equally well.
      const double apart = a.test.statistic - instead.statistic - 2 * (a.test.seen - instead.seen);
      if (significant(b, instead) && candidates_[i].handicap == 0 && beside.log10_p > -2 && apart < 6) {
        out_.pairs.push_back({a.candidate, b});
      }
    }
  }

  std::vector<Candidate> candidates_;
  int given_;
  const SelectionOptions& options_;
  const Refit& refit_;
  std::vector<std::string> why_;
  std::vector<int> chosen_, dropped_;
  int tested_ = 0;
  bool shift_refused_ = false, step_was_little_ = false;
  Selection out_;
};

}  // namespace

double leftover_of(const Selection& selection, const SelectionOptions& options) {
  std::vector<TermGroup> free;
  std::vector<bool> asked;  // of a step that was dropped the columns are gone
  int tested = 0;
  for (std::size_t i = 0; i < selection.alone.size(); ++i) {
    asked.push_back(selection.alone[i].seen > 0 && selection.candidates[i].name != "calibration_shift");
    tested += asked.back() && selection.candidates[i].handicap == 0 ? 1 : 0;
  }
  for (const Accepted& a : selection.accepted) {
    free.push_back(selection.candidates[a.candidate].columns);
    if (static_cast<std::size_t>(a.candidate) < asked.size()) asked[a.candidate] = false;
  }
  double most = 0;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (!asked[i]) continue;
    const EffectTest test = test_effect(selection.problem, selection.candidates[i], free);
    const double log10_p = scatter_over_time(selection.problem, selection.candidates[i], free).log10_p(test.statistic, test.seen);
    const double corrected = log10_p + std::log10(std::max(1, tested)) + selection.candidates[i].handicap;
    if (test.seen > 0 && corrected < options.log10_level) most = std::max(most, test.statistic);
  }
  return most;
}

Selection select_effects(const std::vector<Candidate>& candidates, const SelectionOptions& options, const Refit& refit) {
  return Search(candidates, options, refit).run();
}

}  // namespace host::diagnosis
