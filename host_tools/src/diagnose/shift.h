// A step of one block of theta at an unknown time: the mount was bent, the lens was turned.
//
// Pieces before the step see theta, pieces after it theta + step in one block: the block's columns once more, behind
// the terms, zero before the step. Each block at each instant between two pieces is one trial, with the other unknowns
// free; the most significant one is judged with its number of trials, and against how far the block scatters from piece
// to piece even when the step is allowed for: real recordings disagree with themselves by more than their noise. A
// piece in which the step happens fits neither side; it is recognised by its cost and left out.
#pragma once

#include <optional>

#include "diagnose/selection.h"

namespace host::diagnosis {

/// The most significant step with theta and the groups `free` free, at least `beside` pieces on each side of it.
std::optional<Shift> best_shift(const Problem& problem, const std::vector<TermGroup>& free, std::size_t beside = 2);

/// Is it after the step?
bool is_after(const Shift& shift, const Piece& piece);

/// The problem with the step's columns behind the terms, made of its pieces: their links with each other are lost.
Problem with_shift(const Problem& problem, const Shift& shift);

/// Halves and whole from the pieces.
void sum_pieces(Problem* problem);

/// The same, each side linearised at its own theta where `at_step` does that. Theta of all segments lies between the
/// two: there, rows miss what is curved in a large step, and that looks like other effects and terms.
/// `shift`: the fit may be another than the one that it was found at; its straddling piece is looked up.
Problem stepped(const Problem& problem, const std::vector<TermGroup>& free, const AtStep& at_step, Shift* shift);

/// Of the recording's error level: what steps have of it, over the trials.
double share_of(const Shift& shift);

/// Is a step called, by F where it scatters, and do both halves tell of it? `with`: its columns are in the rows.
bool step_holds(const Problem& with, const Candidate& candidate, const Shift& shift,
                const std::vector<TermGroup>& free);

/// What those columns are called and how large a step may be.
Candidate shift_candidate(const Problem& shifted, const Shift& shift);

}  // namespace host::diagnosis
