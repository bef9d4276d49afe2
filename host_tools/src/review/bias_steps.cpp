#include "review/bias_steps.h"

#include <algorithm>
#include <cmath>

#include "diagnose/chi_square.h"
#include "formatted.h"
#include "reference/finish.h"
#include "replay/kept_segments.h"
#include "review/linearised.h"
#include "review/walk_rows.h"
#include "review/walk_screen.h"

namespace host::review {
namespace {

/// log10 p of the largest of all trials. By Cauchy and Schwarz a step moves no entry by more of its sigmas than the step has itself, and this
/// is where 6 begin: below, nothing can be 5 sigma off by it alone. Of 102 recordings without a step, real IMUs among them, the largest had 5.2 of its sigmas.
constexpr double kLevel = -6;
/// s from either end of a chain of segments: there the first and last states, which nothing holds from the other side, take up what
/// the model lacks (7 sigmas at 0.3 s of an IMU in a hand).
constexpr double kFromEnds_s = 2;

struct Found {
  std::size_t link = 0;
  int axis = 0;                    ///< b_a's x, y, z, then b_g's
  StepTest test;
  double trials = 0;
};

/// Links of a problem, then its walks over gaps, as pairs of states.
std::vector<std::pair<int, int>> links_of(const reference::Problem& problem) {
  std::vector<std::pair<int, int>> out;
  for (const reference::Link& l : problem.links) out.emplace_back(l.from, l.to);
  for (const reference::BiasWalk& w : problem.walks) out.emplace_back(w.from, w.to);
  return out;
}

double seconds(std::int64_t from_ns, std::int64_t to_ns) { return 1e-9 * static_cast<double>(to_ns - from_ns); }

/// Far enough from where its chain begins and ends?
bool inside(const reference::Problem& problem, const std::pair<int, int>& link) {
  const auto state = [&problem](int i) -> const reference::State& { return problem.states[static_cast<std::size_t>(i)]; };
  const std::vector<int>& starts = problem.chain_starts;
  const auto next = std::upper_bound(starts.begin(), starts.end(), link.first);
  const int last = next == starts.end() ? static_cast<int>(problem.states.size()) - 1 : *next - 1;
  return seconds(state(*(next - 1)).t_ns, state(link.first).t_ns) >= kFromEnds_s && seconds(state(link.second).t_ns, state(last).t_ns) >= kFromEnds_s;
}

Found largest(const reference::Problem& problem, const WalkRows& rows) {
  Found out;
  const std::vector<std::pair<int, int>> links = links_of(problem);
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (!inside(problem, links[i])) continue;
    for (int axis = 0; axis < 6; ++axis) {
      const StepTest test = rows.test(i, axis);
      if (!(test.sigma > 0)) continue;
      out.trials += 1;
      if (out.test.sigma > 0 && std::abs(test.z()) <= std::abs(out.test.z())) continue;
      out.link = i;
      out.axis = axis;
      out.test = test;
    }
  }
  return out;
}

/// "at 31.2 s" of the recording that holds both stamps, or "between 24.0 and 28.2 s".
std::string when(const std::vector<Recording>& sessions, std::int64_t from_ns, std::int64_t to_ns) {
  std::int64_t zero_ns = 0;
  for (const Recording& r : sessions) {
    if (!r.imu.samples.empty() && r.imu.samples.front().t_ns <= from_ns) zero_ns = std::max(zero_ns, r.imu.samples.front().t_ns);
  }
  const double from_s = seconds(zero_ns, from_ns), to_s = seconds(zero_ns, to_ns);
  return to_s - from_s > 1 ? formatted("between %.1f and %.1f s", from_s, to_s) : formatted("at %.1f s", to_s);
}

void find_bias(const Eigen::VectorXd& moves, const ReplayResult& result, Suspect* out) {
  const std::vector<CoreParameter>& p = result.result.parameters;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p[i].verdict == "fixed") continue;
    const double sigmas = std::abs(moves(static_cast<Eigen::Index>(i))) / p[i].sigma;
    if (sigmas <= out->bias_sigmas) continue;
    out->bias_sigmas = sigmas;
    out->moves = p[i].name;
  }
}

reference::Problem problem_at(const ReplayResult& result) {
  reference::Problem problem = reference::problem_of(kept_segments(result));
  problem.theta = result.calibration;
  problem.model.track_walk = 0;    // a track's drift is slow, and its states would be as many as its points
  return problem;
}

}  // namespace

std::optional<Suspect> bias_step(const std::vector<Recording>& sessions, const ReplayResult& result) {
  if (result.result.parameters.size() != parameter_names(result.start).size()) return {};
  const reference::Problem problem = problem_at(result);
  const double noise_scale = result.result.noise_scale;
  if (problem.states.empty() || !may_step(problem, noise_scale)) return {};
  const WalkRows rows(problem);
  if (!rows.solved()) return {};
  const Found found = largest(problem, rows);
  if (!(found.test.sigma > 0)) return {};
  Suspect out;
  out.statistic = std::pow(found.test.z() / noise_scale, 2);
  out.log10_p = std::min(0.0, diagnosis::log10_upper_tail(out.statistic, 1) + std::log10(found.trials));
  if (out.log10_p > kLevel) return {};
  const bool gyro = found.axis >= 3;
  out.name = gyro ? "bias_step.gyro" : "bias_step.accel";
  find_bias(printed_by_columns(result.result.parameters) * rows.moves(found.link, found.axis, found.test.size), result, &out);
  const std::pair<int, int> link = links_of(problem)[found.link];
  const auto t_ns = [&problem](int state) { return problem.states[static_cast<std::size_t>(state)].t_ns; };
  out.words = formatted("the %s's bias steps by %.3g +- %.1g %s (%c) %s, and with that step %s moves by %.1f sigma: calibrate what was before and after it by "
                        "themselves, and look for what trims or restarts the sensor",
                        gyro ? "gyroscope" : "accelerometer", found.test.size, found.test.sigma * noise_scale, gyro ? "rad/s" : "m/s^2", "xyz"[found.axis % 3],
                        when(sessions, t_ns(link.first), t_ns(link.second)).c_str(), out.moves.c_str(), out.bias_sigmas);
  return out;
}

}  // namespace host::review
