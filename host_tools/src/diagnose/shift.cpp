#include "diagnose/shift.h"

#include <cmath>

namespace host::diagnosis {
namespace {

using Eigen::MatrixXd;

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
EffectTest trial(const Problem& problem, const Sums& sums, std::size_t k, const Block& block, int n_free, double noise) {
  const Rows before = widened(sums.before[k], block.columns, false), after = widened(sums.after[k], block.columns, true);
  Problem one;
  one.n_theta = problem.n_theta + n_free;
  one.prior = problem.prior;
  one.all = sum_of({&before, &after});
  one.noise = noise;
  return test_effect(one, {"", {0, block.columns.count}, block.size, 0}, {});
}

}  // namespace

std::optional<Shift> best_shift(const Problem& problem, const std::vector<TermGroup>& free) {
  const std::size_t n = problem.pieces.size();
  if (n < 4 || problem.blocks.empty()) return {};
  const Sums sums = running_sums(problem, free);
  std::optional<Shift> best;
  int trials = 0;
  for (const Block& block : problem.blocks) {
    for (std::size_t k = 2; k + 2 <= n; ++k) {
      const EffectTest test = trial(problem, sums, k, block, free_columns(free), problem.noise);
      trials += test.seen > 0 ? 1 : 0;
      if (test.seen == 0 || (best && test.log10_p >= best->test.log10_p)) continue;
      const double from = problem.pieces[k - 1].end_s, to = problem.pieces[k].start_s;
      const double half_piece = 0.5 * (problem.pieces[k].end_s - problem.pieces[k].start_s);
      best = Shift{block, 0.5 * (from + to), 0.5 * std::abs(to - from) + half_piece, 0, test};
    }
  }
  if (best) best->trials = trials;
  return best;
}

Problem with_shift(const Problem& problem, const Shift& shift) {
  Problem out = problem;
  out.blocks.clear();
  for (Piece& p : out.pieces) {
    p.rows = widened(p.rows, shift.block.columns, 0.5 * (p.start_s + p.end_s) > shift.time_s);
  }
  out.all = sum_where(out.pieces, [](const Piece&) { return true; });
  out.train = sum_where(out.pieces, [](const Piece& p) { return !p.held_out; });
  out.held_out = sum_where(out.pieces, [](const Piece& p) { return p.held_out; });
  return out;
}

Candidate shift_candidate(const Problem& shifted, const Shift& shift) {
  const int first = shifted.all.columns() - shifted.n_theta - shift.block.columns.count;
  return {"calibration_shift", {first, shift.block.columns.count}, shift.block.size, 0};
}

}  // namespace host::diagnosis
