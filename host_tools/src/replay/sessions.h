// Recordings as the commands read them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording.h"

namespace host {

/// The states that device logs begin with: only who replays a log as its device was can use them.
enum class LoggedStates { left_out, kept };

/// Reads recordings with their tracks. Throws InputError where a camera's tracks are missing, and says how to make
/// them. `smooth`: see read_recording(); `stamp_exposure`: so many times the exposure is added to each image's stamp
/// (stamps/exposures.h). What was done to the data is said on stderr.
std::vector<Recording> read_sessions(const std::vector<std::string>& recordings, int n_cameras, bool smooth = false,
                                     std::optional<double> stamp_exposure = {},
                                     LoggedStates states = LoggedStates::left_out);

}  // namespace host
