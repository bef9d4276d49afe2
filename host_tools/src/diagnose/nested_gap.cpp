#include "diagnose/nested_gap.h"

#include <algorithm>

#include "diagnose/shift.h"

namespace host::diagnosis {
namespace {

constexpr std::size_t kFolds = 4;

Rows sum_of_pieces(const std::vector<Piece>& pieces) {
  std::vector<const Rows*> rows;
  for (const Piece& p : pieces) rows.push_back(&p.rows);
  return sum_of(rows);
}

/// These pieces alone, with halves of their own.
Problem part(const Problem& whole, std::vector<Piece> pieces) {
  Problem out = whole;
  std::vector<Piece> half[2];
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    pieces[i].held_out = is_held_out(i);
    half[pieces[i].held_out ? 1 : 0].push_back(pieces[i]);
  }
  out.pieces = std::move(pieces);
  out.all = sum_of_pieces(out.pieces);
  out.train = sum_of_pieces(half[0]);
  out.held_out = sum_of_pieces(half[1]);
  return out;
}

/// What a fold may choose from. Of a step that was dropped the columns are gone.
std::vector<Candidate> open_candidates(const Selection& selection) {
  std::vector<Candidate> out;
  for (std::size_t i = 0; i < selection.candidates.size(); ++i) {
    const bool accepted = std::any_of(selection.accepted.begin(), selection.accepted.end(),
                                      [i](const Accepted& a) { return a.candidate == static_cast<int>(i); });
    if (accepted || selection.candidates[i].name != "calibration_shift") out.push_back(selection.candidates[i]);
  }
  return out;
}

Gap gap_of_fold(const Selection& selection, const std::vector<Candidate>& candidates, const Problem& training, const Problem& own) {
  const Selection chosen = select_effects(candidates, {}, [&training](const std::vector<int>&) { return training; });
  if (chosen.accepted.empty()) {
    Gap missed = fold_gap(training, own, selection.candidates, selection.accepted);
    missed.after_measured = missed.before;
    missed.after_sigma = 0;
    return missed;
  }
  if (!chosen.shifted) return fold_gap(training, own, chosen.candidates, chosen.accepted);
  Shift shift = chosen.shift;
  shift.straddling = -1;  // counted among the training's pieces
  return fold_gap(chosen.problem, with_shift(own, shift), chosen.candidates, chosen.accepted);
}

}  // namespace

Gap nested_gap(const Selection& selection) {
  const Problem& whole = selection.problem;
  Gap out;
  out.floor = whole.noise;
  out.dof = whole.all.dof;
  const std::size_t n = whole.pieces.size();
  if (n < 2 * kFolds) return out;
  const std::vector<Candidate> candidates = open_candidates(selection);
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    std::vector<Piece> others, own;
    for (std::size_t i = 0; i < n; ++i) (i % kFolds == fold ? own : others).push_back(whole.pieces[i]);
    const Gap one = gap_of_fold(selection, candidates, part(whole, std::move(others)), part(whole, std::move(own)));
    out.before += one.before;
    out.after_measured += one.after_measured;
    out.after_sigma += one.after_sigma;
  }
  out.before = std::max(0.0, out.before);
  out.after = std::clamp(out.after_measured - decision::kCountsAsNone * out.after_sigma, 0.0, out.before);
  return out;
}

}  // namespace host::diagnosis
