#include "diagnose/selection.h"

#include <algorithm>
#include <cmath>

#include "diagnose/rivals.h"
#include "diagnose/shift.h"
#include "formatted.h"

namespace host::diagnosis {
namespace {

class Search {
 public:
  Search(const std::vector<Candidate>& candidates, const SelectionOptions& options, const Refit& refit)
      : candidates_(candidates),
        given_(static_cast<int>(candidates.size())),
        options_(options),
        refit_(refit),
        why_(candidates.size()),
        chosen_(options.known) {}

  Selection run() {
    fit_again();
    judge_alone();
    while (static_cast<int>(chosen_.size()) < decision::kMostEffects && step_forward()) step_back();
    finish();
    return out_;
  }

 private:
  /// Effects that would not have shown are out from the start.
  void judge_alone() {
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      out_.alone.push_back(test_alone(out_.problem, candidates_[i]));
      if (out_.alone.back().seen == 0) out_.cannot_tell.push_back(static_cast<int>(i));
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

  std::vector<int> open() const {
    std::vector<int> out;
    for (int c = 0; c < static_cast<int>(candidates_.size()); ++c) {
      if (open_to(c)) out.push_back(c);
    }
    return out;
  }

  /// log10 p over the share of the level: what hypotheses of different shares are compared by.
  double weighed(int c, const EffectTest& test) const { return test.log10_p - std::log10(candidates_[c].share); }
  bool significant(int c, const EffectTest& test) const {
    return test.seen > 0 && called(test.log10_p, candidates_[c].share);
  }

  /// Candidates that are significant with the chosen ones free, the most significant first.
  std::vector<std::pair<double, int>> calls() {
    std::vector<std::pair<double, int>> order;
    for (int c : open()) {
      EffectTest test = test_effect(out_.problem, candidates_[c], groups_but(-1));
      if (!significant(c, test)) continue;  // F asks for more
      test = judge_effect(out_.problem, candidates_[c], groups_but(-1));
      if (significant(c, test)) {
        order.emplace_back(weighed(c, test), c);
      } else {
        why_[c] = "its value is not the same throughout the recording";
      }
    }
    std::sort(order.begin(), order.end());
    return order;
  }

  /// Accepts a step, the effect that says most by far, or the most significant one that both halves tell of.
  bool step_forward() {
    const std::vector<std::pair<double, int>> order = calls();
    if (offer_shift(order)) return true;
    const int first = dominant_of(out_.problem, candidates_, groups_but(-1), open());
    if (first >= 0 && !dropped_before(first)) {
      const bool passes = significant(first, tested(first, groups_but(-1))) && holds(first);
      if (passes ? take(first) : try_out(first)) return true;
    }
    for (const auto& [p, c] : order) {
      if (c == refused_at_its_fit_ || !holds(c)) continue;
      if (!dropped_before(c)) return take(c);
      why_[c] = "not needed beside the others";
    }
    return false;
  }

  /// False if no time is left for the fit.
  bool take(int c) {
    if (options_.work && !options_.work->allows_fit()) return false;
    refused_at_its_fit_ = -1;
    chosen_.push_back(c);
    fit_again();
    return true;
  }

  /// Do both halves tell of it, beside the other chosen ones? Says why not.
  bool holds(int c) {
    const std::string why = halves_refuse(out_.problem, candidates_[c], groups_but(c));
    if (!why.empty()) why_[c] = why;
    return why.empty();
  }

  /// Fits with it. It stays if it passes there, where its value is the one at which rows are linearised.
  bool try_out(int c) {
    if (!take(c)) return false;
    const bool is_called = significant(c, tested(c, groups_but(c)));
    if (is_called && holds(c)) return true;
    if (!is_called) why_[c] = "with it in the fit, its value is not the same throughout the recording";
    chosen_.pop_back();
    fit_again();
    refused_at_its_fit_ = c;
    return false;
  }

  /// The core knows the effects of the catalogue; a step, the first candidate behind those given, is put on top.
  void fit_again() {
    std::vector<int> known;
    for (int c : chosen_) {
      if (c < given_) known.push_back(c);
    }
    out_.problem = refit_(known);
    if (out_.shifted) out_.problem = stepped(out_.problem, groups_but(given_), options_.at_step, &out_.shift);
  }

  /// A step that says more than every effect becomes one candidate more.
  bool offer_shift(const std::vector<std::pair<double, int>>& others) {
    if (out_.shifted || shift_refused_) return false;
    std::optional<Shift> step = best_shift(out_.problem, groups_but(-1));
    if (!step || !called(step->test.log10_p, share_of(*step))) return false;
    if (says_more_than(*step, others, out_.problem, candidates_, groups_but(-1))) return false;
    if (is_little(step->test)) {
      shift_refused_ = step_was_little_ = true;
      return false;
    }
    out_.problem = stepped(out_.problem, groups_but(-1), options_.at_step, &*step);
    const Candidate candidate = shift_candidate(out_.problem, *step);
    step->test = test_effect(out_.problem, candidate, groups_but(-1));
    if (step->test.seen == 0 || !step_holds(out_.problem, candidate, *step, groups_but(-1))) {
      shift_refused_ = true;
      fit_again();
      return false;
    }
    out_.shifted = true;
    out_.shift = *step;
    candidates_.push_back(candidate);
    why_.emplace_back();
    out_.alone.push_back(step->test);
    chosen_.push_back(static_cast<int>(candidates_.size()) - 1);
    return true;
  }

  bool is_little(const EffectTest& step) const {
    double others = 0;
    for (int c : chosen_) {
      if (c < given_) others += test_effect(out_.problem, candidates_[c], groups_but(c)).statistic;
    }
    return step.statistic < decision::kStepOfOthers * others;
  }

  bool dropped_before(int c) const { return std::count(dropped_.begin(), dropped_.end(), c) > 0; }

  /// The same test that it was taken by. A step has its own (offer_shift).
  EffectTest tested(int c, const std::vector<TermGroup>& free) const {
    return c < given_ ? judge_effect(out_.problem, candidates_[c], free)
                      : test_effect(out_.problem, candidates_[c], free);
  }

  /// Drops what the newer ones make superfluous.
  void step_back() {
    for (std::size_t i = 0; i + 1 < chosen_.size();) {
      const int c = chosen_[i];
      const EffectTest beside = tested(c, groups_but(c));
      if (std::count(options_.known.begin(), options_.known.end(), c) > 0 ||
          (significant(c, beside) && !(c >= given_ && is_little(beside)))) {
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
    for (int c : chosen_) out_.accepted.push_back({c, tested(c, groups_but(c))});
    for (const Accepted& a : out_.accepted) {
      for (int b : rivals_of(out_.problem, candidates_, a.candidate, groups_but(a.candidate), open()))
        out_.pairs.push_back({a.candidate, b});
    }
    if (const std::optional<Shift> step = step_was_little_ ? best_shift(out_.problem, groups_but(-1)) : std::nullopt) {
      if (called(step->test.log10_p, share_of(*step)))
        out_.leftover.take(step->test.chi2, "calibration_shift of " + step->block.name);
    }
    const Leftover refused = leftover_of(out_);
    out_.leftover.take(refused.chi2, refused.what);
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const int c = static_cast<int>(i);
      if (!is_chosen(c) && significant(c, out_.alone[i])) out_.rejected.push_back({c, reason(c)});
    }
  }

  std::string reason(int c) const {
    for (const Pair& pair : out_.pairs) {
      if (pair.other == c) return "this motion does not tell it from " + candidates_[pair.accepted].name;
    }
    const bool left = open_to(c) && significant(c, test_effect(out_.problem, candidates_[c], groups_but(-1)));
    if (!why_[c].empty() && (left || dropped_before(c))) return why_[c];
    return chosen_.empty() ? "not significant" : "explained by " + candidates_[chosen_.front()].name;
  }

  std::vector<Candidate> candidates_;
  int given_;
  const SelectionOptions& options_;
  const Refit& refit_;
  std::vector<std::string> why_;
  std::vector<int> chosen_, dropped_;
  int refused_at_its_fit_ = -1;  ///< beside those that are chosen now
  bool shift_refused_ = false, step_was_little_ = false;
  Selection out_;
};

}  // namespace

Selection select_effects(const std::vector<Candidate>& candidates, const SelectionOptions& options,
                         const Refit& refit) {
  return Search(candidates, options, refit).run();
}

}  // namespace host::diagnosis
