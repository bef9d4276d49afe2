#include "diagnose/held_out_report.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnose/answer.h"
#include "formatted.h"

namespace host::diagnosis {
namespace {

void tell_sensors(const std::array<SensorGap, kSensors>& gaps, Diagnosis* out) {
  for (int s = 0; s < kSensors; ++s) {
    const auto put = [s](SensorShares* to, double value) {
      (s == 0 ? to->camera : s == 1 ? to->gyro : to->accel) = value;
    };
    put(&out->before, gaps[s].before);
    put(&out->after, gaps[s].after);
    put(&out->noise_floor, gaps[s].floor);
    put(&out->gap_sigma, gaps[s].sigma);
    put(&out->gap_dof, gaps[s].dof);
  }
}

/// What an effect with a name, or a term without one, is about.
unsigned about(const std::string& effect, const CoreTerm& term) {
  if (effect != kUnlisted) return hypothesis(effect).about;
  return term.kind < 3 ? of_gyro : term.kind < 6 ? of_accel : of_lens;
}

/// Whose effects would make residuals follow this. A turn, and a moment other than the stated one, shift an image and
/// do not zoom it: above and below the middle its radial parts are opposite. What is radial and follows anything is the
/// lens, as one whose focus moves with the force on it.
unsigned families_behind(const Structure& s) {
  if (s.axis == "radial") return of_lens;
  const auto begins = [&s](const char* words) { return s.against.rfind(words, 0) == 0; };
  if (begins("force")) return of_accel;
  if (begins("image motion") || begins("image line") || begins("rate") || begins("change of rate"))
    return of_gyro | of_timing;
  if (begins("image") || begins("distance")) return of_lens;
  return of_nothing;
}

std::string why_no_name(const Gap& gap, const Leftover& leftover, bool closes) {
  const double closed = 100 * std::max(0.0, gap.closed_but_for_chance()),
               rest = gap.before > 0 ? 100 * gap.rest / gap.before : 0;
  const std::string most = leftover.what.empty() ? "" : ", most " + leftover.what;
  if (closes)
    return formatted("the excess falls by %.1f %%, but %.1f %% clearly follow something else", closed, rest) + most;
  return formatted("the excess falls by only %.0f %%, the rest is something else", closed) + most;
}

constexpr const char* kNotConfirmed =
    "with a quarter of the recording held out at a time, the rest mostly does not call for it";

/// Terms without a name claim nothing; of an effect that was told before the fit refines the value only.
std::vector<bool> confirmed_effects(const Selection& s, const std::vector<Fold>& folds, const Told& told) {
  std::vector<bool> out;
  for (std::size_t i = 0; i < s.accepted.size(); ++i) {
    const std::string& name = s.candidates[s.accepted[i].candidate].name;
    out.push_back(name == kUnlisted || told.has(name) || folds_confirm(s, folds, i));
  }
  return out;
}

/// Of what all effects take off chi2, each beside the others.
double unconfirmed_share(const Selection& s, const std::vector<bool>& confirmed) {
  double all = 0, lost = 0;
  for (std::size_t i = 0; i < s.accepted.size(); ++i) {
    all += s.accepted[i].test.statistic;
    if (!confirmed[i]) lost += s.accepted[i].test.statistic;
  }
  return all > 0 ? lost / all : 0;
}

class Report {
 public:
  Report(const HeldOut& held_out, Diagnosis* out) : h_(held_out), out_(out) {
    for (const Accepted& a : h_.selection.accepted) {
      if (candidate(a).kind == Kind::term) nameless_[about(kUnlisted, first_term(a))] += a.test.statistic;
    }
  }

  bool has_catalogue() const {
    return std::any_of(h_.selection.accepted.begin(), h_.selection.accepted.end(),
                       [this](const Accepted& a) { return candidate(a).kind != Kind::term; });
  }

  /// `refused`: why nothing gets a name; empty: it does.
  void add(std::size_t i, const std::string& refused) {
    const Accepted& a = h_.selection.accepted[i];
    const bool step = candidate(a).kind == Kind::step;
    DiagnosedEffect effect = step ? named(h_.selection.shift, a) : named(candidate(a), a, h_.terms);
    effect.gap_closed = std::clamp(
        held_out_gap_of(h_.selection.problem, h_.selection.candidates, h_.selection.accepted, i).closed(), 0.0, 1.0);
    if (!refused.empty()) {
      out_->rejected.push_back({effect.name == kUnlisted ? effect.words : effect.name, refused});
      return;
    }
    if (step) tell_before_step();
    if (!step) add_to_model(a, effect);
    if (!step && effect.name != kUnlisted) take_back_name(a, &effect);
    find_pairs(a, &effect);
    out_->effects.push_back(effect);
  }

 private:
  const Candidate& candidate(const Accepted& a) const { return h_.selection.candidates[a.candidate]; }
  const CoreTerm& first_term(const Accepted& a) const { return h_.terms[candidate(a).columns.first].term; }

  /// Theta with the step and all other effects free, counted from the fit.
  void tell_before_step() {
    const Problem& p = h_.selection.problem;
    std::vector<TermGroup> groups;
    for (const Accepted& a : h_.selection.accepted) groups.push_back(candidate(a).columns);
    const Eigen::VectorXd x = solve(with_groups(with_prior(p.all, p.prior), p.n_theta, groups)).x;
    const TermGroup& block = h_.selection.shift.block.columns;
    out_->before_step.assign(x.data() + block.first, x.data() + block.first + block.count);
  }

  void add_to_model(const Accepted& a, const DiagnosedEffect& effect) {
    const TermGroup& g = candidate(a).columns;
    for (int k = 0; k < g.count; ++k) {
      const TermInfo& t = h_.terms[g.first + k];
      out_->model.push_back({t.effect, t.bit, t.term, effect.parameters[k]});
    }
  }

  /// An effect beside which a term without a name is needed in the same sensor may be the lowest order of something
  /// else: the radial and tangential parts of a lens that is decentred in a way that neither says. It keeps its name
  /// only if it explains nine tenths of what both do; it stays in the model in any case.
  void take_back_name(const Accepted& a, DiagnosedEffect* effect) {
    for (const auto& [family, statistic] : nameless_) {
      if ((about(effect->name, first_term(a)) & family) == 0) continue;
      if (a.test.statistic >= decision::kNamesFrom * (a.test.statistic + statistic)) continue;
      out_->rejected.push_back(
          {effect->name, "it is needed, but only beside a term without a name in the same sensor"});
      effect->words = "unlisted effect, of which " + effect->name + " is a part";
      effect->name = kUnlisted;
      return;
    }
  }

  void find_pairs(const Accepted& a, DiagnosedEffect* effect) const {
    if (effect->name == kUnlisted) return;
    for (const Pair& pair : h_.selection.pairs) {
      if (pair.accepted != a.candidate) continue;
      effect->or_else.push_back(h_.selection.candidates[pair.other].name);
      effect->separates = separates(effect->name, effect->or_else.back());
    }
  }

  const HeldOut& h_;
  Diagnosis* out_;
  std::map<unsigned, double> nameless_;  ///< statistics of terms without a name
};

}  // namespace

void report_gap(const HeldOut& held_out, Diagnosis* out) {
  const Selection& s = held_out.selection;
  const Gap gap = held_out_gap(s.problem, s.candidates, s.accepted, held_out.floors[0], s.leftover.chi2);
  Report report(held_out, out);
  const double unit = gap.dof > 0 ? 1 / (gap.dof * gap.floor) : 0;
  const bool closes = gap.before > 0 && gap.closed_but_for_chance() >= decision::kNamesFrom;
  const std::vector<Fold> folds = folds_of(s, held_out.joined);
  const Gap nested = nested_gap(s, folds);
  const bool names = closes && (gap.rest <= decision::kMostRest * gap.before || !report.has_catalogue());
  const Gap& measured = nested.before > 0 ? nested : gap;
  const double rest = nested.before > 0 ? gap.rest : 0;  // held_out_gap has it in its own
  out->before.total = (measured.before + rest) * unit;
  out->after.total = (measured.after + rest) * unit;
  out->after_sigma = measured.after_sigma * unit;
  const std::vector<bool> confirmed = confirmed_effects(s, folds, held_out.told);
  const double open = names ? std::min(1.0, 1 - gap.closed_but_for_chance() + unconfirmed_share(s, confirmed)) : 1;
  out->open_excess = gap.before > 0 ? open * out->before.total : 0;
  out->noise_floor.total = gap.floor;
  out->gap_dof.total = gap.dof;
  for (std::size_t i = 0; i < s.accepted.size(); ++i)
    report.add(i, !names ? why_no_name(gap, s.leftover, closes) : confirmed[i] ? "" : kNotConfirmed);
  tell_sensors(gap_by_sensor(s, folds, held_out.sensors, held_out.floors), out);
  out->gap_closed = out->before.total > 0 ? std::clamp(1 - out->after.total / out->before.total, 0.0, 1.0) : 0;
}

void refuse_where_structure_is_left(const std::vector<Structure>& left, Diagnosis* out) {
  double sum = 0;  // the gap is shared in proportion to what each effect takes off chi2 beside the others
  for (const DiagnosedEffect& e : out->effects) sum += e.statistic;
  for (const Structure& s : left) {
    if (s.log10_p >= decision::kLog10StructureLeft) continue;
    const unsigned behind = families_behind(s);
    const double says = -2 * std::log(10.0) * s.log10_p;  // twice the logarithm of its odds, as a statistic is
    const auto refused = [behind, says, out](const DiagnosedEffect& e) {
      if (says <= decision::kMostRest * e.statistic) return false;
      const auto term =
          std::find_if(out->model.begin(), out->model.end(), [&e](const ModelTerm& t) { return t.effect == e.name; });
      return term != out->model.end() && (about(e.name, term->term) & behind) != 0;
    };
    for (std::size_t i = out->effects.size(); i-- > 0;) {
      const DiagnosedEffect e = out->effects[i];
      if (!refused(e)) continue;
      out->rejected.push_back({e.name, "with it " + s.sensor + " " + s.axis + " still follows " + s.against});
      out->after.total = std::min(out->before.total, out->after.total + e.statistic / sum * out->before.total);
      out->open_excess = std::min(out->before.total, out->open_excess + e.statistic / sum * out->before.total);
      out->effects.erase(out->effects.begin() + static_cast<std::ptrdiff_t>(i));
      out->model.erase(
          std::remove_if(out->model.begin(), out->model.end(), [&e](const ModelTerm& t) { return t.effect == e.name; }),
          out->model.end());
    }
  }
  out->gap_closed = out->before.total > 0 ? std::clamp(1 - out->after.total / out->before.total, 0.0, 1.0) : 0;
}

}  // namespace host::diagnosis
