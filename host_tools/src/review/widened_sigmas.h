// Sigmas by stated noise become those that the recording itself bears out.
#pragma once

#include <vector>

#include "replay/replay.h"

namespace host::review {

/// Largest of what the segments' scatter says (segment_scatter.h) and of what is known without the one that tells most
/// (one_segment.h), then what start and recording are apart (start_conflict.h). Sets sigmas, verdicts, covariance,
/// `health.noise_sigmas` and `health.segment_scatter`. Returns the notes on it.
std::vector<Note> widen_sigmas(Core& core, ReplayResult* out);

}  // namespace host::review
