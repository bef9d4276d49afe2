#include "diagnose/shift.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnose/chi_square.h"

namespace host::diagnosis {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double middle(const Piece& p) { return 0.5 * (p.start_s + p.end_s); }

/// Rows with `extra` columns before the rhs: copies of theta's block, or zeroes.
Rows widened(const Rows& rows, const TermGroup& block, bool after) {
  const int n = rows.columns();
  MatrixXd wide = MatrixXd::Zero(rows.R.rows(), n + block.count + 1);
  wide.leftCols(n) = rows.R.leftCols(n);
  if (after) wide.middleCols(n, block.count) = rows.R.middleCols(block.first, block.count);
  wide.col(n + block.count) = rows.R.col(n);
  return {triangle_of(wide), rows.dof};
}

Rows sum_where(const std::vector<Piece>& pieces, const std::function<bool(const Piece&)>& taken) {
  std::vector<const Rows*> chosen;
  for (const Piece& p : pieces) {
    if (taken(p)) chosen.push_back(&p.rows);
  }
  return sum_of(chosen);
}

/// Sums before and after each instant between pieces, over theta and the free groups only.
struct Sums {
  std::vector<Rows> before, after;  ///< [k]: pieces [0, k) and [k, n)
};

Sums running_sums(const Problem& problem, const std::vector<TermGroup>& free) {
  const std::size_t n = problem.pieces.size();
  std::vector<Rows> narrow;
  for (const Piece& p : problem.pieces) narrow.push_back(with_groups(p.rows, problem.n_theta, free));
  Sums out;
  out.before.resize(n + 1);
  out.after.resize(n + 1);
  for (std::size_t k = 0; k < n; ++k) {
    out.before[k + 1] = k == 0 ? narrow[0] : sum_of({&out.before[k], &narrow[k]});
    const std::size_t j = n - 1 - k;
    out.after[j] = k == 0 ? narrow[j] : sum_of({&narrow[j], &out.after[j + 1]});
  }
  return out;
}

int free_columns(const std::vector<TermGroup>& free) {
  int n = 0;
  for (const TermGroup& g : free) n += g.count;
  return n;
}

/// One trial: the test of the step's columns on [theta | free | step].
EffectTest trial(const Problem& problem, const Sums& sums, std::size_t k, const Block& block, int n_free,
                 double noise) {
  const Rows before = widened(sums.before[k], block.columns, false),
             after = widened(sums.after[k], block.columns, true);
  Problem one;
  one.n_theta = problem.n_theta + n_free;
  one.prior = problem.prior;
  one.all = sum_of({&before, &after});
  one.noise = noise;
  return test_effect(one, {kCalibrationShift, {0, block.columns.count}, block.size, share_of(Kind::step), Kind::step},
                     {});
}

/// |residual|^2 of the fit to these rows.
double least_cost(const Problem& problem, const std::vector<const Rows*>& sets) {
  return solve(with_prior(sum_of(sets), problem.prior)).cost;
}

/// Does a piece beside the step fit neither side? Its share of the cost is compared with its degrees of freedom.
void look_inside(const Problem& problem, const std::vector<TermGroup>& free, Shift* shift) {
  double worst = decision::kFitsNeither;
  for (std::size_t j = 1; j + 1 < problem.pieces.size(); ++j) {  // with one on either side
    const bool after = is_after(*shift, problem.pieces[j]);
    const bool beside = after ? !is_after(*shift, problem.pieces[j - 1]) : is_after(*shift, problem.pieces[j + 1]);
    if (!beside) continue;
    std::vector<Rows> wide;
    for (const Piece& p : problem.pieces) {
      wide.push_back(
          widened(with_groups(p.rows, problem.n_theta, free), shift->block.columns, middle(p) > shift->time_s));
    }
    std::vector<const Rows*> all, others;
    for (std::size_t i = 0; i < wide.size(); ++i) {
      all.push_back(&wide[i]);
      if (i != j) others.push_back(&wide[i]);
    }
    const double dof = problem.pieces[j].rows.dof,
                 share = (least_cost(problem, all) - least_cost(problem, others)) / problem.noise;
    const double sigmas = (share - dof) / std::sqrt(2 * dof);
    if (sigmas < worst) continue;
    worst = sigmas;
    shift->straddling = static_cast<int>(j);
  }
}

}  // namespace

std::optional<Shift> best_shift(const Problem& problem, const std::vector<TermGroup>& free, std::size_t beside) {
  const std::size_t n = problem.pieces.size();
  if (n < 4 || problem.blocks.empty()) return {};
  const Sums sums = running_sums(problem, free);
  std::optional<Shift> best;
  int trials = 0;
  for (const Block& block : problem.blocks) {
    for (std::size_t k = beside; k + beside <= n; ++k) {
      const EffectTest test = trial(problem, sums, k, block, free_columns(free), problem.noise);
      trials += test.seen > 0 ? 1 : 0;
      if (test.seen == 0 || (best && test.log10_p >= best->test.log10_p)) continue;
      const double from = problem.pieces[k - 1].end_s, to = problem.pieces[k].start_s;
      const double half_piece = 0.5 * (problem.pieces[k].end_s - problem.pieces[k].start_s);
      best = Shift{block, 0.5 * (from + to), 0.5 * std::abs(to - from) + half_piece, 0, -1, test};
    }
  }
  if (!best) return {};
  best->trials = trials;
  if (log10_upper_tail(best->test.statistic, best->test.seen) < decision::kLog10LookInside)
    look_inside(problem, free, &*best);
  if (best->straddling >= 0) {
    const Piece& p = problem.pieces[best->straddling];
    best->time_s = middle(p);
    best->uncertainty_s = 0.29 * (p.end_s - p.start_s);  // anywhere in it: length / sqrt(12)
    const Problem without = with_shift(problem, *best);
    best->test = test_effect(without, shift_candidate(without, *best), free);
  }
  return best;
}

bool is_after(const Shift& shift, const Piece& piece) { return middle(piece) > shift.time_s; }

Problem with_shift(const Problem& problem, const Shift& shift) {
  Problem out = problem;
  out.blocks.clear();
  if (shift.straddling >= 0) out.pieces.erase(out.pieces.begin() + shift.straddling);
  for (Piece& p : out.pieces) {
    p.rows = widened(p.rows, shift.block.columns, is_after(shift, p));
  }
  sum_pieces(&out);
  return out;
}

void sum_pieces(Problem* problem) {
  problem->all = sum_where(problem->pieces, [](const Piece&) { return true; });
  problem->train = sum_where(problem->pieces, [](const Piece& p) { return !p.held_out; });
  problem->held_out = sum_where(problem->pieces, [](const Piece& p) { return p.held_out; });
}

namespace {

/// The piece that the step falls into, of this fit's: another set of effects may keep other segments.
int piece_around(double time_s, const std::vector<Piece>& pieces) {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (pieces[i].start_s < time_s && time_s < pieces[i].end_s) return static_cast<int>(i);
  }
  return -1;
}

/// Theta and the step beside `free`, with the wide prior on the step that its own test has: a direction that one side
/// hardly tells would lead anywhere.
VectorXd theta_and_step(const Problem& with, const Candidate& step, std::vector<TermGroup> free) {
  free.push_back(step.columns);
  const Rows rows = with_groups(with.all, with.n_theta, free);
  Prior prior = with.prior;
  prior.mean.conservativeResizeLike(VectorXd::Zero(rows.columns()));
  prior.sigma.conservativeResizeLike(VectorXd::Constant(rows.columns(), std::numeric_limits<double>::infinity()));
  prior.sigma.tail(step.columns.count) =
      decision::kWidePrior * Eigen::Map<const VectorXd>(step.size.data(), step.columns.count);
  return solve(with_prior(rows, prior)).x;
}

}  // namespace

Problem stepped(const Problem& problem, const std::vector<TermGroup>& free, const AtStep& at_step, Shift* shift) {
  if (shift->straddling >= 0) shift->straddling = piece_around(shift->time_s, problem.pieces);
  const Problem with = with_shift(problem, *shift);
  if (!at_step) return with;
  const VectorXd x = theta_and_step(with, shift_candidate(with, *shift), free), before = x.head(with.n_theta);
  VectorXd after = before;
  const TermGroup& block = shift->block.columns;
  after.segment(block.first, block.count) += x.tail(block.count);
  return with_shift(at_step(*shift, before, after), *shift);
}

double share_of(const Shift& shift) { return share_of(Kind::step) / std::max(1, shift.trials); }

bool step_holds(const Problem& with, const Candidate& candidate, const Shift& shift,
                const std::vector<TermGroup>& free) {
  const Scatter scatter = scatter_over_time(with, candidate, free);
  const bool by_chance = log10_upper_tail(scatter.factor * scatter.dof, scatter.dof) > decision::kLog10Scatters;
  const double log10_p = by_chance ? shift.test.log10_p : scatter.log10_p(shift.test.statistic, shift.test.seen);
  return called(log10_p, share_of(shift)) && halves_refuse(with, candidate, free).empty();
}

Candidate shift_candidate(const Problem& shifted, const Shift& shift) {
  const int first = shifted.all.columns() - shifted.n_theta - shift.block.columns.count;
  return {kCalibrationShift, {first, shift.block.columns.count}, shift.block.size, share_of(Kind::step), Kind::step};
}

}  // namespace host::diagnosis
