// Recordings as the commands read them.
#pragma once

#include <string>
#include <vector>

#include "recording.h"

namespace host {

/// Reads recordings with their tracks. Throws InputError where a camera's tracks are missing, and says how to make
/// them. `smooth`: see read_recording(); what it did is said on stderr.
std::vector<Recording> read_sessions(const std::vector<std::string>& recordings, int n_cameras, bool smooth = false);

}  // namespace host
