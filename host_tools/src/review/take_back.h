// What takes `calibrated` back where something would move a released value, also what only an earlier replay has shown.
#pragma once

#include "replay/replay.h"

namespace host::review {

constexpr double kMostBias = 3;  ///< sigmas that a missing effect may move a released value by
/// The same of a step, of a bias or of theta: chance moves one of 26 entries by 3 more, which makes 5.
constexpr double kMostStepBias = 2;

/// Everything as it was, and why.
void take_back(const char* status, const std::string& why, ReplayResult* out);

/// `insufficient` where fewer than half of the values are observed with all that sigmas hold.
void refuse_unobserved(ReplayResult* out);

/// Takes over what the review of an earlier replay of the same recordings suspects and this one no longer shows, or is
/// no longer certain of: noise hides what moves the answer little. An effect counts in the sigmas of now, and takes
/// `calibrated` back as above; else sigmas grow by what it moves (review/suspected_moves.h). A step is only said: held
/// against tracks that drift and count as white, chance makes steps (one of ten simulated recordings along real paths),
/// and this replay has looked for it by what the tracks show.
void keep_suspects(const ReplayResult& earlier, ReplayResult* now);

}  // namespace host::review
