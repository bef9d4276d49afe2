// The state file of a replay: what it has seen already must not be counted again.
#pragma once

#include "replay/provenance.h"
#include "state/state_file.h"

namespace host {

/// Throws InputError if a session is a device log, or has the rotation
/// rates of one that the state has seen, or of another one here.
void expect_new_sessions(const std::vector<Recording>& sessions, const StateFile& state);

/// Before the replay: the logs that the state has seen, for the result.
std::vector<LogIdentity> seen_logs(const StateFile& state);

/// After the replay: adds the logs of these sessions, in their order, and replaces the file.
void write_state(const std::vector<Recording>& sessions, const std::vector<LogIdentity>& logs, StateFile* state);

}  // namespace host
