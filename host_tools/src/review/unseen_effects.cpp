#include "review/unseen_effects.h"

#include <algorithm>
#include <cmath>

#include "formatted.h"
#include "review/linearised.h"
#include "review/take_back.h"

namespace host::review {
namespace {

using namespace diagnosis;

/// By parameter, as printed; with the terms of `groups`, of these sizes.
Eigen::VectorXd variances(const Problem& problem, double variance, const std::vector<TermGroup>& groups,
                          const std::vector<double>& sizes, const Eigen::MatrixXd& printed) {
  const auto m = static_cast<Eigen::Index>(sizes.size());
  Prior prior = problem.prior;
  prior.mean.conservativeResize(problem.n_theta + m);
  prior.mean.tail(m).setZero();
  prior.sigma.conservativeResize(problem.n_theta + m);
  prior.sigma.tail(m) = Eigen::Map<const Eigen::VectorXd>(sizes.data(), m);
  Rows rows = with_groups(problem.all, problem.n_theta, groups);
  rows.R /= std::sqrt(variance);
  const Solution s = solve(with_prior(rows, prior));
  const Eigen::MatrixXd of_theta = s.covariance.topLeftCorner(problem.n_theta, problem.n_theta);
  return (printed * of_theta).cwiseProduct(printed).rowwise().sum();
}

/// The value that an effect moves by most of its sigmas.
struct Worst {
  const UnseenEffect* effect;
  const CoreParameter* moved;
  double move, sigmas;
};

Worst worst_of(const UnseenEffect& effect, const std::vector<CoreParameter>& parameters) {
  Worst out{&effect, nullptr, 0, 0};
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double sigmas = effect.moves[i] / parameters[i].sigma;
    if (parameters[i].verdict == "fixed" || !(sigmas > out.sigmas)) continue;
    out = {&effect, &parameters[i], effect.moves[i], sigmas};
  }
  return out;
}

std::string words_on(const Worst& w) {
  const std::string unit = w.moved->unit == "-" ? "" : " " + w.moved->unit;
  return formatted("%s (%s by %.2g%s, %.0f sigma)", w.effect->name.c_str(), w.moved->name.c_str(), w.move, unit.c_str(),
                   w.sigmas);
}

}  // namespace

UnseenEffect unseen_effect(const Problem& problem, const Candidate& candidate, double variance,
                           const std::vector<CoreParameter>& parameters) {
  const Eigen::MatrixXd printed = printed_by_columns(parameters);
  const Eigen::VectorXd more = variances(problem, variance, {candidate.columns}, candidate.size, printed) -
                               variances(problem, variance, {}, {}, printed);
  UnseenEffect out{candidate.name, {}};
  for (const double moved2 : more) out.moves.push_back(std::sqrt(std::max(0.0, moved2)));
  return out;
}

void note_unseen_effects(ReplayResult* result) {
  constexpr std::size_t kNamed = 3;
  constexpr char kName[] = "unseen_effects";
  Health& health = result->health;
  health.notes.erase(
      std::remove_if(health.notes.begin(), health.notes.end(), [&](const Note& n) { return n.name == kName; }),
      health.notes.end());
  if (result->result.status != "calibrated") return;
  std::vector<Worst> worst;
  for (const UnseenEffect& e : health.unseen) {
    const auto same = [&e](const Suspect& s) { return s.name == e.name; };
    if (std::any_of(health.suspects.begin(), health.suspects.end(), same)) continue;
    const Worst w = worst_of(e, result->result.parameters);
    if (w.sigmas > kMostBias) worst.push_back(w);
  }
  if (worst.empty()) return;
  std::sort(worst.begin(), worst.end(), [](const Worst& a, const Worst& b) { return a.sigmas > b.sigmas; });
  std::string list;
  for (std::size_t i = 0; i < std::min(kNamed, worst.size()); ++i) list += (i > 0 ? ", " : "") + words_on(worst[i]);
  if (worst.size() > kNamed) list += formatted(" and %zu more", worst.size() - kNamed);
  health.notes.push_back({kName, worst.front().sigmas,
                          "the sigmas assume a device without effects that this motion can hardly tell from the "
                          "calibration. Of usual size they may move values with no trace in the residuals: " +
                              list + ". If your device may have one, --enable it, or record richer motion"});
}

}  // namespace host::review
