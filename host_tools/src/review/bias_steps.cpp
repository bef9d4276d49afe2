#include "review/bias_steps.h"

#include <algorithm>
#include <cmath>

#include "diagnose/chi_square.h"
#include "reference/finish.h"
#include "reference/solve.h"
#include "replay/kept_segments.h"
#include "review/linearised.h"
#include "review/suspected_moves.h"
#include "review/walk_rows.h"
#include "review/walk_screen.h"
#include "review/when.h"

namespace host::review {
namespace {

/// log10 p of the largest of all trials; of 160 links that is 6.1 sigmas. By Cauchy and Schwarz a step moves no entry
/// by more of its sigmas than it has itself, so that below hardly any can be 5 off by it alone. Of recordings without a
/// step, real IMUs among them, the largest had 4.7 away from the ends of a chain, where stamps do not scatter.
constexpr double kStepLevel = -6;
/// s from either end of a chain of segments: there the first and last states, which nothing holds from the other side,
/// take up what the model lacks (7 sigmas at 0.3 s of an IMU in a hand).
constexpr double kFromEnds_s = 2;
/// Links that one test stands for at first: a second apart or less, steps are hardly told from each other.
constexpr std::size_t kStride = 4;

/// The reference must find the fit that the core found: of recordings with sound stamps its sum of squares is within 1
/// % of the core's. Its cubics through stamps that scatter by 1 ms may overshoot (12 and 37 times the core's): there it
/// would find steps of its own.
constexpr double kSameFit = 1.1;

struct Found {
  std::size_t link = 0;
  int axis = 0;  ///< b_a's x, y, z, then b_g's
  StepTest test;
};

/// Links of a problem, then its walks over gaps, as pairs of states.
std::vector<std::pair<int, int>> links_of(const reference::Problem& problem) {
  std::vector<std::pair<int, int>> out;
  for (const reference::Link& l : problem.links) out.emplace_back(l.from, l.to);
  for (const reference::BiasWalk& w : problem.walks) out.emplace_back(w.from, w.to);
  return out;
}

/// Far enough from where its chain begins and ends?
bool inside(const reference::Problem& problem, const std::pair<int, int>& link) {
  const auto state = [&problem](int i) -> const reference::State& {
    return problem.states[static_cast<std::size_t>(i)];
  };
  const std::vector<int>& starts = problem.chain_starts;
  const auto next = std::upper_bound(starts.begin(), starts.end(), link.first);
  const int last = next == starts.end() ? static_cast<int>(problem.states.size()) - 1 : *next - 1;
  return seconds_between(state(*(next - 1)).t_ns, state(link.first).t_ns) >= kFromEnds_s &&
         seconds_between(state(link.second).t_ns, state(last).t_ns) >= kFromEnds_s;
}

void take_larger(const WalkRows& rows, std::size_t link, int axis, Found* out) {
  const StepTest test = rows.test(link, axis);
  if (!(test.sigma > 0) || (out->test.sigma > 0 && std::abs(test.z()) <= std::abs(out->test.z()))) return;
  *out = {link, axis, test};
}

/// Every few links first, and all walks over gaps, then around the largest.
Found largest(const reference::Problem& problem, const WalkRows& rows) {
  Found out;
  const std::vector<std::pair<int, int>> links = links_of(problem);
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (i < problem.links.size() && i % kStride != 0) continue;
    for (int axis = 0; axis < 6 && inside(problem, links[i]); ++axis) take_larger(rows, i, axis, &out);
  }
  if (!(out.test.sigma > 0) || out.link >= problem.links.size()) return out;
  const std::size_t from = out.link - std::min(out.link, kStride - 1),
                    to = std::min(out.link + kStride, problem.links.size());
  for (std::size_t i = from; i < to; ++i) {
    if (inside(problem, links[i])) take_larger(rows, i, out.axis, &out);
  }
  return out;
}

/// By how much all values move, of theta's columns that do, and which released one most.
void find_bias(const Eigen::VectorXd& moves, const ReplayResult& result, Suspect* out) {
  std::vector<CoreParameter> p = result.result.parameters;
  p.resize(static_cast<std::size_t>(moves.size()));  // without the effects
  const Eigen::VectorXd printed = printed_by_columns(p) * moves;
  out->moved.assign(printed.data(), printed.data() + printed.size());
  find_largest(
      p, printed, [](const CoreParameter&) { return true; }, out);
}

/// Effects of the image that the calibration estimated, and the reference does not know, are in the core's residuals:
/// points are moved so that the reference's are those. False where that cannot be done.
bool take_residuals(const KeptSegments& kept, reference::Problem* problem) {
  std::size_t at = 0;
  for (const CoreKept& k : kept.segments) {
    std::size_t known = 0;
    for (const CorePoint& z : k.measured) {
      reference::Point& point = problem->points[at++];
      if (z.rejected) continue;
      Eigen::Vector2d r;
      if (known == k.points.size() || !reference::point_residual(*problem, point, &r)) return false;
      const CorePointResidual& core = k.points[known++];
      point.uv += r - kept.model.pixel_sigma * Eigen::Vector2d(core.u_sigma, core.v_sigma);
    }
    if (known != k.points.size()) return false;
  }
  return true;
}

/// What was calibrated, where it stands now; empty where an effect of the IMU was estimated.
std::optional<reference::Problem> problem_at(const ReplayResult& result) {
  const KeptSegments kept = kept_segments(result);
  if (kept.segments.empty()) return {};
  reference::Problem problem = reference::problem_of(kept);
  problem.theta = result.calibration;
  // A track's drift would have as many states as the track has points: all of its error after a second counts as white.
  problem.model.pixel_sigma = std::hypot(problem.model.pixel_sigma, problem.model.track_walk);
  problem.model.track_walk = 0;
  if (kept.effects.empty()) return problem;
  const auto of_imu = [](const std::string& name) { return name.rfind("gyro", 0) == 0 || name.rfind("accel", 0) == 0; };
  if (kept.model.track_walk > 0 || std::any_of(kept.effects.begin(), kept.effects.end(), of_imu) ||
      !take_residuals(kept, &problem))
    return {};
  return problem;
}

}  // namespace

std::optional<Suspect> bias_step(const std::vector<Recording>& sessions, const ReplayResult& result) {
  const std::optional<reference::Problem> problem = problem_at(result);
  if (!problem || !may_step(*problem)) return {};
  const WalkRows rows(*problem);
  if (!rows.solved()) return {};
  if (rows.cost() > kSameFit * result.result.chi2) return {};
  const Found found = largest(*problem, rows);
  if (!(found.test.sigma > 0)) return {};
  const double noise_scale = result.result.noise_scale;
  const std::vector<std::pair<int, int>> links = links_of(*problem);
  Suspect out;
  out.statistic = std::pow(found.test.z() / noise_scale, 2);
  out.log10_p = std::min(
      0.0, diagnosis::log10_upper_tail(out.statistic, 1) + std::log10(6.0 * static_cast<double>(links.size())));
  if (out.log10_p > kStepLevel) return {};
  const bool gyro = found.axis >= 3;
  out.name = gyro ? "bias_step.gyro" : "bias_step.accel";
  find_bias(rows.moves(found.link, found.axis, found.test.size), result, &out);
  const auto t_ns = [&problem](int state) { return problem->states[static_cast<std::size_t>(state)].t_ns; };
  const std::pair<int, int> link = links[found.link];
  out.words = formatted(
      "the %s's bias steps by %.3g +- %.1g %s (%c) %s, and with that step %s moves by %.1f sigma: calibrate what was "
      "before and after it by themselves, and look for what trims or restarts the sensor",
      gyro ? "gyroscope" : "accelerometer", found.test.size, found.test.sigma * noise_scale, gyro ? "rad/s" : "m/s^2",
      "xyz"[found.axis % 3], when(sessions, t_ns(link.first), t_ns(link.second)).c_str(), out.moves.c_str(),
      out.bias_sigmas);
  return out;
}

}  // namespace host::review
