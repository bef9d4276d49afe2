// What `segcal replay` says on the terminal.
#pragma once

#include "replay/replay.h"

namespace host {

/// One line that counts on a terminal, a line per quarter in a log; on standard error. `fraction`: 0 to 1.
void show_replay_progress(double fraction);
/// `went_on`: from the state that earlier recordings left, or with that in its log.
void print_replay_summary(const ReplayResult& r, bool went_on);

}  // namespace host
