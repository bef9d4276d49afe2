// Where a replayed device begins: as created, from a state file, or with the state in its own log.
#pragma once

#include "replay/replay.h"

namespace host {

/// Whether it is a device's log that begins with the device's state.
bool begins_with_state(const Recording& session);

/// Before all else. Throws InputError where logs with states are not in order, or a state behind the first log cannot
/// be taken.
void check_states(const std::vector<Recording>& sessions, const ReplayOptions& options);

/// The state of options.state or of the first session's log goes into `core`, which was not fed.
/// Throws InputError with the file's name if it is not whole, or of another device or profile.
void begin_device(const Recording& first, const ReplayOptions& options, Core* core);

/// A log that begins with a state, behind others: what they leave in `core` must be that state. Throws InputError.
void expect_left_state(const Recording& session, const ReplayOptions& options, Core* core);

}  // namespace host
