#include "review/missing_effects.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "diagnose/decision.h"
#include "diagnose/exposure_offset.h"
#include "review/kept_exposures.h"
#include "review/linearised.h"
#include "review/mean_warmth.h"
#include "review/segment_scatter.h"
#include "review/suspected_moves.h"

namespace host::review {
namespace {

using namespace diagnosis;

constexpr double kLevel = -4;  // log10 p of a false suspicion, corrected
/// The same of one that sigmas hold only: nobody is misled by sigmas that are too large once in a hundred recordings.
constexpr double kHeldLevel = -2;
/// Degrees of freedom that the scatter of theta's values counts for in the scatter of another value: how far effects'
/// scatters differ from it beyond chance. By moments of their logarithms 16 on 42 simulated recordings, 5 on ten with
/// real IMUs.
constexpr int kPooledDof = 5;

/// Fewer than four segments show no scatter, and are judged by noise. Four know the scatter of one value so badly that
/// 30 of its sigmas may be chance: moderated by what all values of the recording show (Smyth, "Linear models and
/// empirical Bayes methods", Statistical Applications in Genetics and Molecular Biology 3, 2004, section 3). Asked
/// beside the scatter of the value alone, so that a false suspicion is twice as likely as kLevel at most.
Scatter moderated(const Scatter& own, double pooled) {
  const int dof = own.dof + kPooledDof;
  return {(own.dof * own.factor + kPooledDof * std::max(1.0, pooled)) / dof, dof};
}

/// Of theta's values, over what noise leaves.
double pooled_scatter(const Problem& problem) {
  const Eigen::MatrixXd each = Eigen::MatrixXd::Identity(problem.n_theta, problem.n_theta);
  return scatter_of_segments(problem, each, dispersion(problem, {})).pooled;
}

/// k1, p1, w: with another term of the lens' shape beside it a coefficient stands for something else.
bool is_lens_shape(const std::string& name) {
  const std::string last = name.substr(name.find('.') + 1);
  return name.rfind("cam", 0) == 0 && (last == "w" || (last.size() == 2 && (last[0] == 'k' || last[0] == 'p')));
}

bool bends_lens(const std::string& effect) { return effect == "radial_residual" || effect == "tangential_residual"; }

Eigen::VectorXd variances(const Eigen::MatrixXd& printed, const Eigen::MatrixXd& covariance) {
  return (printed * covariance).cwiseProduct(printed).rowwise().sum();
}

/// In each parameter's unit. The variance of a movement is the larger variance less the smaller one.
std::vector<double> biases(const std::vector<CoreParameter>& parameters, const Eigen::VectorXd& moved,
                           const Eigen::VectorXd& without, const Eigen::VectorXd& with) {
  std::vector<double> out(parameters.size(), 0);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (without(k) > 0) out[i] = beyond_chance(moved(k), parameters[i].sigma * std::sqrt(with(k) / without(k) - 1));
  }
  return out;
}

/// With the candidate free, how all values move, and the largest movement of a released one in its stated sigmas. No
/// real lens is quite of its model: without `lens_shape` coefficients of its shape do not count, but what keeps its
/// meaning does.
void find_bias(const Problem& problem, const Candidate& candidate, const ReplayResult& result, bool lens_shape,
               Suspect* out) {
  const std::vector<CoreParameter>& p = result.result.parameters;
  const Solution without = solve(with_prior(with_groups(problem.all, problem.n_theta, {}), problem.prior));
  const Solution with =
      solve(with_groups(with_prior(problem.all, problem.prior), problem.n_theta, {candidate.columns}));
  const Eigen::MatrixXd printed = printed_by_columns(p);
  const Eigen::VectorXd moved = printed * (with.x.head(problem.n_theta) - without.x);
  out->moved = biases(p, moved, variances(printed, without.covariance),
                      variances(printed, with.covariance.topLeftCorner(problem.n_theta, problem.n_theta)));
  find_largest(
      p, moved, [lens_shape](const CoreParameter& q) { return lens_shape || !is_lens_shape(q.name); }, out);
}

/// Terms that a calibration estimated are no candidates any more.
Catalogue not_estimated(Catalogue catalogue, const std::vector<CoreParameter>& parameters) {
  const auto taken = [&parameters](const std::string& name) {
    return std::any_of(parameters.begin(), parameters.end(),
                       [&name](const CoreParameter& p) { return p.name == name; });
  };
  Catalogue out;
  for (Candidate c : catalogue.candidates) {
    if (taken(catalogue.terms[static_cast<std::size_t>(c.columns.first)].name)) continue;
    const int first = static_cast<int>(out.terms.size());
    for (int i = 0; i < c.columns.count; ++i)
      out.terms.push_back(catalogue.terms[static_cast<std::size_t>(c.columns.first + i)]);
    c.columns.first = first;
    out.candidates.push_back(c);
  }
  return out;
}

std::string number(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// kappa is told roughly: an exposure changes within a segment, and only stamps that were moved know that.
std::string remedy(const Candidate& c, const EffectTest& test) {
  if (c.kind != Kind::exposure) return "--enable " + c.name;
  return "about " + number("--stamp-exposure %.1f", test.value(0)) + "; segcal diagnose tells it well";
}

/// As if many segments had shown that scatter.
double log10_p_of_known(const Scatter& scatter, const EffectTest& test) {
  return log10_upper_tail(test.statistic / scatter.factor, test.seen);
}

struct Asked {
  EffectTest test;
  bool called = false, certain = false, by_itself = false;
  double log10_p = 0;
};

/// Few segments know their scatter so badly that F calls nothing below a statistic of a hundred. What would be called
/// if that scatter were exact is called too, without being certain: sigmas can hold it, and nothing is refused for it.
Asked ask(const Problem& problem, const Candidate& c, std::size_t trials, double pooled) {
  Asked out;
  out.test = test_alone(problem, c);
  if (out.test.seen == 0) return out;
  const double of_many = std::log10(static_cast<double>(trials));
  const auto log10_p_by = [&](const Scatter& s) { return s.log10_p(out.test.statistic, out.test.seen) + of_many; };
  const Scatter own = scatter_over_time(problem, c, {}), with_all = moderated(own, pooled);
  out.by_itself = log10_p_by(own) <= kLevel;
  const Scatter& judge = out.by_itself ? own : with_all;
  out.log10_p = log10_p_by(judge);
  out.test.sigma *= std::sqrt(judge.factor);
  out.certain = out.log10_p <= kLevel;
  out.called = out.certain || log10_p_of_known(with_all, out.test) + of_many <= kHeldLevel;
  return out;
}

std::string values_of(const Catalogue& catalogue, const Candidate& c, const EffectTest& test) {
  std::string out;
  for (int i = 0; i < c.columns.count && i < 3; ++i) {
    const TermInfo& t = catalogue.terms[static_cast<std::size_t>(c.columns.first + i)];
    out += (i > 0 ? ", " : "") + t.name + " " + number("%.3g", test.value(i)) + " +- " +
           number("%.1g ", test.sigma(i)) + t.unit;
  }
  return out;
}

std::string words_on(const Suspect& suspect, const Candidate& c, const EffectTest& test, const std::string& values) {
  std::string out = c.name + (suspect.certain ? " is not in the model and would explain what is left ("
                                              : " may be missing from the model: it would explain what is left (");
  out += values;
  if (bends_lens(c.name)) out += "; the lens' own coefficients stand for something else beside it";
  out += suspect.certain ? ")" : "), though the segments are too few, or scatter too much, to be sure";
  return out + "; with it " + suspect.moves + " moves by " + number("%.1f", suspect.bias_sigmas) +
         " sigma: " + remedy(c, test);
}

/// False if the data do not ask for the effect; true also where they do and contradict themselves.
bool asks_for(const Problem& problem, const Catalogue& catalogue, const Candidate& c, std::size_t trials, double pooled,
              const ReplayResult& result, std::vector<Suspect>* out) {
  const Asked asked = ask(problem, c, trials, pooled);
  if (!asked.called) return false;
  const EffectTest& test = asked.test;
  const HalvesTest halves = test_halves(problem, c, {});
  if (halves.log10_p_disagree < decision::kLog10Disagree || halves.gain < decision::kHelps * test.statistic)
    return asked.certain;
  Suspect suspect;
  suspect.name = c.name;
  suspect.statistic = test.statistic;
  suspect.log10_p = asked.log10_p;
  suspect.certain = asked.certain;
  find_bias(problem, c, result, asked.by_itself || !bends_lens(c.name), &suspect);
  suspect.words = words_on(suspect, c, test, values_of(catalogue, c, test));
  out->push_back(std::move(suspect));
  return true;
}

/// Beside nothing but time_offset, which has the column that exposures scale: for it there is room in any profile.
void ask_for_exposures(Core& core, const ReplayResult& result, const std::vector<double>& exposure_s,
                       std::size_t trials, std::vector<Suspect>* out) {
  Catalogue asked;
  for (const TermInfo& t : not_estimated(core_catalogue(false), result.result.parameters).terms)
    if (t.effect == "time_offset") asked.terms.push_back(t);
  Problem problem = linearised(core, result, asked.terms);
  if (problem.held_out.empty()) return;
  ExposureColumn column;
  column.at = static_cast<int>(asked.terms.size());
  for (std::size_t i = 0; i < result.result.parameters.size(); ++i)
    if (result.result.parameters[i].name == "time_offset.t_d") column.of = static_cast<int>(i) - problem.n_theta;
  add_exposure_column(exposure_s, &column, &problem);
  asked.terms.push_back(exposure_term());
  Candidate c{kExposureOffset, {column.at, 1}, {asked.terms.back().size}, share_of(Kind::exposure), Kind::exposure};
  if (column.at > 0) c.beside = {{0, column.at}};
  asks_for(problem, asked, c, trials, pooled_scatter(problem), result, out);
}

}  // namespace

std::vector<Suspect> missing_effects(Core& core, const ReplayResult& result, const std::vector<Recording>& sessions,
                                     bool has_temperature, std::vector<UnseenEffect>* unseen) {
  std::vector<Suspect> out;
  const Catalogue catalogue = not_estimated(core_catalogue(has_temperature), result.result.parameters);
  const std::vector<double> exposure_s = kept_exposures(result, sessions);
  const std::size_t trials = catalogue.candidates.size() + (exposure_s.empty() ? 0 : 1);
  const auto ask_all = [&](const Catalogue& part) {
    Problem problem = linearised(core, result, part.terms);
    if (problem.held_out.empty()) return;
    count_from_mean_warmth(result.result.parameters, part.terms, &problem);
    const double pooled = pooled_scatter(problem), variance = dispersion(problem, {}) * std::max(1.0, pooled);
    for (const Candidate& c : part.candidates) {
      if (!asks_for(problem, part, c, trials, pooled, result, &out))
        unseen->push_back(unseen_effect(problem, c, variance, result.result.parameters));
    }
  };
  try {
    ask_all(catalogue);
  } catch (const InputError&) {  // no room for all at once
    for (const Candidate& c : catalogue.candidates) {
      Catalogue one{{}, {c}};
      for (int i = 0; i < c.columns.count; ++i)
        one.terms.push_back(catalogue.terms[static_cast<std::size_t>(c.columns.first + i)]);
      one.candidates[0].columns.first = 0;
      try {
        ask_all(one);
      } catch (const InputError&) {  // nor for this one: this profile cannot be asked about it
      }
    }
  }
  if (!exposure_s.empty()) ask_for_exposures(core, result, exposure_s, trials, &out);
  std::sort(out.begin(), out.end(), [](const Suspect& a, const Suspect& b) {
    return std::pair(a.certain, a.statistic) > std::pair(b.certain, b.statistic);
  });
  return out;
}

}  // namespace host::review
