// A calibration that stands although something is suspected says by how much that may move it.
#pragma once

#include "replay/replay.h"

namespace host::review {

/// Sigmas and covariance with what a suspect would move: C + d d', d being its `moved`. So they hold whether it is
/// right or not. None exceeds its prior's; one above half of it is `weak`.
void widen_by(Suspect& suspect, ReplayResult* out);

}  // namespace host::review
