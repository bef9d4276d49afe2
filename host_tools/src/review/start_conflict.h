// Do the start and the recording contradict each other where neither outweighs the other?
#pragma once

#include <optional>
#include <vector>

#include "replay/replay.h"

namespace host::review {

/// By how much each sigma grows; 1 where nothing contradicts. A weak value whose sigma is at least half of its start's
/// is a mean of what the start and what the recording say. Where it is more than three of the start's sigmas away from
/// the start, one of the two is wrong, and the mean is as uncertain as they are apart: its sigma grows by the number of
/// these sigmas (the ratio of Birge, "The calculation of errors by the method of least squares", Phys. Rev. 1932, for
/// two measurements), also beyond the start's, which is not to be believed then. By stated noise the step has a
/// variance of prior^2 - sigma^2 (Box, "Sampling and Bayes' inference in scientific modelling and robustness", J. R.
/// Stat. Soc. A 1980), three quarters of the start's at most here.
std::vector<double> start_conflict_factors(const std::vector<CoreParameter>& parameters);

/// The note `start_conflict`, if any of these is above 1.
std::optional<Note> note_on_start_conflict(const std::vector<CoreParameter>& parameters,
                                           const std::vector<double>& factors);

}  // namespace host::review
