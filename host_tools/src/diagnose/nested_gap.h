// The held-out gap on segments that were used neither to choose the effects nor to fit them.
//
// Four folds, every fourth pair of neighbouring segments one of them. Pairs, because biases and
// scales that temperature moves show where one segment is joined to the next, and in no segment by itself. For each
// fold the whole selection (selection.h) runs again on the other three quarters, by linear algebra on the rows of the
// last fit, and what it takes is fitted to these. Against the fold's own rows the change that it predicts is measured
// as in gap.h. A fold for which nothing is chosen closes nothing: its excess is measured along what the whole recording
// says, and stays. So the figure holds the chance to miss an effect, which a gap that is only measured for given names
// does not, and it is measured whether or not a name was given.
//
// What all folds share is the point of linearisation (with its outliers) and the instant of a step.
#pragma once

#include <functional>
#include <optional>

#include "diagnose/gap.h"

namespace host::diagnosis {

/// Segments that were held out, and what the others say.
struct Fold {
  Problem training, own;            ///< over the same columns
  std::vector<std::size_t> places;  ///< of its own segments among the selection's pieces
  std::vector<Candidate> candidates;
  std::vector<Accepted> accepted;  ///< chosen by the training
  bool chooses = false;            ///< the training chose; with few segments it is asked nothing
  bool missed = false;             ///< nothing was chosen: `accepted` is what the whole recording says
  std::optional<Shift> shift;      ///< whose columns stand behind those of the selection's pieces
};

/// Rows of the segments at these places among a problem's pieces, joined where one follows the other.
using JoinedRows = std::function<Rows(const std::vector<std::size_t>& places)>;

/// Not joined: the links with each other are lost. `pieces` has to outlive it.
JoinedRows sums_of_pieces(const std::vector<Piece>& pieces);

/// Four; with fewer than eight segments the two halves, with the whole recording's choice. With a step in the model
/// rows are sums of pieces, since its columns are.
std::vector<Fold> folds_of(const Selection& selection, const JoinedRows& joined);

/// `rest` is left at zero: it is of the whole recording (held_out_gap). Zero with fewer than eight segments.
Gap nested_gap(const Selection& selection, const std::vector<Fold>& folds);

/// Do enough folds choose this effect themselves, or what it makes a pair with (decision::kFoldsConfirm)? Yes, where
/// none was asked.
bool folds_confirm(const Selection& selection, const std::vector<Fold>& folds, std::size_t accepted);

}  // namespace host::diagnosis
