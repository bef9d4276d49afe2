#include "review/calibration_step.h"

#include <algorithm>
#include <cmath>

#include "diagnose/fit_rows.h"
#include "diagnose/shift.h"
#include "review/linearised.h"
#include "review/names.h"
#include "review/segment_scatter.h"
#include "review/suspected_moves.h"
#include "review/when.h"

namespace host::review {
namespace {

using namespace diagnosis;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// log10 p of a false step, corrected for the number of trials.
constexpr double kCalibrationStepLevel = -4;

/// What the segments scatter by where the step is allowed for, its size no less free than theta is.
Scatter scatter_beside(const Problem& with, const Candidate& step) {
  Problem both = with;
  const int first = with.n_theta;
  both.n_theta += step.columns.count;
  both.prior.mean.conservativeResizeLike(VectorXd::Zero(both.n_theta));
  both.prior.sigma.conservativeResize(both.n_theta);
  for (int i = 0; i < step.columns.count; ++i)
    both.prior.sigma(first + i) = decision::kWidePrior * step.size[static_cast<std::size_t>(i)];
  const SegmentScatter found =
      scatter_of_segments(both, MatrixXd::Identity(both.n_theta, both.n_theta), dispersion(with, {step.columns}));
  return {std::max(1.0, found.pooled), std::max(1, static_cast<int>(std::lround(found.pooled_dof)))};
}

/// Printed values after the step, less those that were released.
VectorXd moved_by(const Problem& problem, const Problem& with, const Shift& shift, const Candidate& step,
                  const std::vector<CoreParameter>& parameters) {
  const int n = problem.n_theta;
  const Solution without = solve(with_prior(with_groups(problem.all, n, {}), problem.prior));
  const Solution free = solve(with_groups(with_prior(with.all, with.prior), n, {step.columns}));
  VectorXd after = free.x.head(n);
  after.segment(shift.block.columns.first, shift.block.columns.count) += free.x.tail(shift.block.columns.count);
  return printed_by_columns(parameters) * (after - without.x);
}

/// Between the middles of the segments on both sides.
std::string step_when(const std::vector<Recording>& sessions, const ReplayResult& result,
                      const std::vector<Piece>& pieces, const Shift& shift) {
  const std::vector<const CoreKept*> kept = in_order(result);
  std::size_t after = 0;
  while (0.5 * (pieces[after].start_s + pieces[after].end_s) <= shift.time_s) ++after;
  const std::size_t before = shift.straddling >= 0 ? static_cast<std::size_t>(shift.straddling) - 1 : after - 1;
  const CoreSegment &a = kept[before]->segment, &b = kept[after]->segment;
  if (a.session != b.session) return formatted("between session %u and %u", a.session + 1, b.session + 1);
  return when(sessions, a.start_ns + (a.end_ns - a.start_ns) / 2, b.start_ns + (b.end_ns - b.start_ns) / 2);
}

/// Beside the most significant step, one that falls short of it by no more than this says the same, and motion does not
/// tell which it was: chi-square of one direction, 1 of 400.
constexpr double kRival = 9;

/// " (or gyro.m: this motion does not tell them apart)"; of each block the most significant step.
std::string rivals_of(Problem problem, const Shift& best, double factor) {
  std::vector<std::string> names;
  for (const Block& block : std::vector<Block>(problem.blocks)) {
    if (block.name == best.block.name) continue;
    problem.blocks = {block};
    const std::optional<Shift> other = best_shift(problem, {}, 1);
    if (other && other->test.seen > 0 && other->test.statistic > best.test.statistic - kRival * factor)
      names.push_back(block.name);
  }
  return names.empty() ? "" : " (or " + names_of(names) + " changes: this motion does not tell them apart)";
}

/// "rotates by 0.7 deg", "changes by 3 %".
std::string size_of(const std::string& block, double size) {
  const std::string last = block.substr(block.find('.') + 1);
  if (last == "r_CI" || last == "r_AI") return formatted("rotates by %.2g deg", size * 180 / M_PI);
  if (last == "p_CI") return formatted("moves by %.2g mm", 1e3 * size);
  if (last == "f" || last == "c") return formatted("moves by %.2g px", size);
  return formatted("changes by %.2g", size);
}

}  // namespace

std::optional<Suspect> calibration_step(const std::vector<Recording>& sessions, Core& core,
                                        const ReplayResult& result) {
  Problem problem = linearised(core, result, {});
  problem.blocks = blocks_of(result.calibration);
  const std::optional<Shift> shift = best_shift(problem, {}, 1);
  if (!shift || shift->test.seen == 0) return {};
  const Problem with = with_shift(problem, *shift);
  const Candidate step = shift_candidate(with, *shift);
  Suspect out;
  out.statistic = shift->test.statistic;
  const Scatter scatter = scatter_beside(with, step);
  out.log10_p =
      std::min(0.0, scatter.log10_p(out.statistic, shift->test.seen) + std::log10(static_cast<double>(shift->trials)));
  if (out.log10_p > kCalibrationStepLevel) return {};
  out.name = "calibration_shift." + shift->block.name;
  const VectorXd moved = moved_by(problem, with, *shift, step, result.result.parameters);
  out.moved.assign(moved.data(), moved.data() + moved.size());
  find_largest(
      result.result.parameters, moved, [](const CoreParameter&) { return true; }, &out);
  out.words = formatted(
      "%s %s %s%s, and what came after it puts %s %.1f sigma from the answer: calibrate what was before and after it "
      "by "
      "themselves",
      shift->block.name.c_str(), size_of(shift->block.name, shift->test.value.norm()).c_str(),
      step_when(sessions, result, problem.pieces, *shift).c_str(), rivals_of(problem, *shift, scatter.factor).c_str(),
      out.moves.c_str(), out.bias_sigmas);
  return out;
}

}  // namespace host::review
