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

/// The segments at `places` against what the others choose.
Fold fold_of(const Selection& selection, const std::vector<Candidate>& candidates,
             const std::vector<std::size_t>& places) {
  const Problem& whole = selection.problem;
  std::vector<Piece> others, own;
  for (std::size_t i = 0; i < whole.pieces.size(); ++i) {
    (std::count(places.begin(), places.end(), i) > 0 ? own : others).push_back(whole.pieces[i]);
  }
  Fold out{part(whole, std::move(others)),
           part(whole, std::move(own)),
           places,
           selection.candidates,
           selection.accepted,
           false,
           {}};
  if (whole.pieces.size() < 2 * kFolds) return out;
  const Selection chosen = select_effects(candidates, {}, [&out](const std::vector<int>&) { return out.training; });
  out.missed = chosen.accepted.empty();
  if (out.missed) return out;
  out.candidates = chosen.candidates;
  out.accepted = chosen.accepted;
  if (!chosen.shifted) return out;
  out.shift = chosen.shift;
  out.shift->straddling = -1;  // counted among the training's pieces
  out.training = chosen.problem;
  out.own = with_shift(out.own, *out.shift);
  return out;
}

}  // namespace

std::vector<Fold> folds_of(const Selection& selection) {
  const std::size_t n = selection.problem.pieces.size(), folds = n < 2 * kFolds ? 2 : kFolds;
  std::vector<Fold> out;
  if (n < 2) return out;
  const std::vector<Candidate> candidates = open_candidates(selection);
  for (std::size_t fold = 0; fold < folds; ++fold) {
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < n; ++i) {
      if (i % folds == fold) places.push_back(i);
    }
    out.push_back(fold_of(selection, candidates, places));
  }
  return out;
}

Gap nested_gap(const Selection& selection, const std::vector<Fold>& folds) {
  const Problem& whole = selection.problem;
  Gap out;
  out.floor = whole.noise;
  out.dof = whole.all.dof;
  if (whole.pieces.size() < 2 * kFolds) return out;
  for (const Fold& fold : folds) {
    const Gap one = fold_gap(fold.training, fold.own, fold.candidates, fold.accepted);
    out.before += one.before;
    out.after_measured += fold.missed ? one.before : one.after_measured;
    out.after_sigma += fold.missed ? 0 : one.after_sigma;
  }
  out.before = std::max(0.0, out.before);
  out.after = std::clamp(out.after_measured - decision::kCountsAsNone * out.after_sigma, 0.0, out.before);
  return out;
}

}  // namespace host::diagnosis
