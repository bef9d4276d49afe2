// Effects beside each other: which one says most by far, and which ones a motion does not tell apart.
#pragma once

#include "diagnose/selection.h"

namespace host::diagnosis {

/// Of the candidates `open`, the one that says several times as much as each other one, whether or not its value is the
/// same throughout; -1: none. With the columns of `free` free.
int dominant_of(const Problem& problem, const std::vector<Candidate>& candidates, const std::vector<TermGroup>& free,
                const std::vector<int>& open);

/// Is an effect more significant than a step? Or, where both halves tell of it, as significant if its scatter counts as
/// little as the step's (an effect is not less one for being held against it), or likelier by its evidence (a minute
/// may show a little of each of the six ways in which a temperature moves the camera, and all of a step's three).
/// `effects`: log10 p by F over the share of the level, and the candidate's place; those of effects that are called.
bool says_more_than(const Shift& step, const std::vector<std::pair<double, int>>& effects, const Problem& problem,
                    const std::vector<Candidate>& candidates, const std::vector<TermGroup>& free);

/// Of the candidates `open`, those that alone explain as much as `accepted`, and beside which that adds nothing; with
/// the columns of `others` free.
std::vector<int> rivals_of(const Problem& problem, const std::vector<Candidate>& candidates, int accepted,
                           const std::vector<TermGroup>& others, const std::vector<int>& open);

}  // namespace host::diagnosis
