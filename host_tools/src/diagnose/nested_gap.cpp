#include "diagnose/nested_gap.h"

#include <algorithm>

#include "diagnose/shift.h"

namespace host::diagnosis {
namespace {

constexpr std::size_t kFolds = 4;

/// Pairs of neighbours, so that half of the links between segments stay; the halves are made of the same (selection.h).
std::size_t pair_of(std::size_t place) { return (place + 1) / 2; }

/// These segments alone. Their pairs go to the halves by turns.
Problem part(const Problem& whole, const std::vector<std::size_t>& places, const JoinedRows& joined) {
  Problem out = whole;
  out.pieces.clear();
  bool held_out = false;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i > 0 && pair_of(places[i]) != pair_of(places[i - 1])) held_out = !held_out;
    out.pieces.push_back(whole.pieces[places[i]]);
    out.pieces.back().held_out = held_out;
  }
  out.all = joined(places);
  out.train = out.held_out = {};
  return out;
}

/// What a selection asks besides.
void join_halves(const std::vector<std::size_t>& places, const JoinedRows& joined, Problem* out) {
  std::vector<std::size_t> half[2];
  for (std::size_t i = 0; i < places.size(); ++i) half[out->pieces[i].held_out ? 1 : 0].push_back(places[i]);
  out->train = joined(half[0]);
  out->held_out = joined(half[1]);
}

/// What a fold may choose from. Of a step that was dropped the columns are gone.
std::vector<Candidate> open_candidates(const Selection& selection) {
  std::vector<Candidate> out;
  for (std::size_t i = 0; i < selection.candidates.size(); ++i) {
    const bool accepted = std::any_of(selection.accepted.begin(), selection.accepted.end(),
                                      [i](const Accepted& a) { return a.candidate == static_cast<int>(i); });
    if (accepted || selection.candidates[i].kind != Kind::step) out.push_back(selection.candidates[i]);
  }
  return out;
}

/// The segments at `places` against what the others choose.
Fold fold_of(const Selection& selection, const std::vector<Candidate>& candidates,
             const std::vector<std::size_t>& places, const JoinedRows& joined) {
  const Problem& whole = selection.problem;
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < whole.pieces.size(); ++i) {
    if (std::count(places.begin(), places.end(), i) == 0) others.push_back(i);
  }
  Fold out{part(whole, others, joined),
           part(whole, places, joined),
           places,
           selection.candidates,
           selection.accepted,
           false,
           false,
           {}};
  if (whole.pieces.size() < 2 * kFolds) return out;
  join_halves(others, joined, &out.training);
  const Selection chosen = select_effects(candidates, {}, [&out](const std::vector<int>&) { return out.training; });
  out.chooses = true;
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

JoinedRows sums_of_pieces(const std::vector<Piece>& pieces) {
  return [&pieces](const std::vector<std::size_t>& places) {
    std::vector<const Rows*> rows;
    for (std::size_t i : places) rows.push_back(&pieces[i].rows);
    return sum_of(rows);
  };
}

std::vector<Fold> folds_of(const Selection& selection, const JoinedRows& joined) {
  const std::size_t n = selection.problem.pieces.size(), folds = n < 2 * kFolds ? 2 : kFolds;
  std::vector<Fold> out;
  if (n < 2) return out;
  const std::vector<Candidate> candidates = open_candidates(selection);
  const JoinedRows rows = selection.shifted ? sums_of_pieces(selection.problem.pieces) : joined;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < n; ++i) {
      if (pair_of(i) % folds == fold) places.push_back(i);
    }
    out.push_back(fold_of(selection, candidates, places, rows));
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

bool folds_confirm(const Selection& selection, const std::vector<Fold>& folds, std::size_t accepted) {
  const int own = selection.accepted[accepted].candidate;
  std::vector<std::string> names{selection.candidates[own].name};
  for (const Pair& pair : selection.pairs) {
    if (pair.accepted == own) names.push_back(selection.candidates[pair.other].name);
  }
  const auto chooses = [&names](const Fold& fold) {
    return !fold.missed && std::any_of(fold.accepted.begin(), fold.accepted.end(), [&](const Accepted& a) {
      return std::count(names.begin(), names.end(), fold.candidates[a.candidate].name) > 0;
    });
  };
  const auto asked = std::count_if(folds.begin(), folds.end(), [](const Fold& fold) { return fold.chooses; });
  const auto agree = std::count_if(folds.begin(), folds.end(), chooses);
  return asked == 0 || static_cast<double>(agree) >= decision::kFoldsConfirm * static_cast<double>(asked);
}

}  // namespace host::diagnosis
