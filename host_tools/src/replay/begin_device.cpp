#include "replay/begin_device.h"

#include <memory>

namespace host {
namespace {

void restore_logged(const Recording& session, Core* core) {
  FlashImage flash{session.device->state};
  try {
    core->restore(&flash);
  } catch (const InputError& error) {
    throw InputError(session.root.string() + ": begins with a device's state: " + error.what() +
                     "; with --without-state its data alone are replayed");
  }
}

/// A device as it would be stored now.
std::string stored(Core* core) {
  FlashImage flash;
  core->save(&flash);
  return flash.bytes;
}

}  // namespace

bool begins_with_state(const Recording& session) { return session.device && !session.device->state.empty(); }

void check_states(const std::vector<Recording>& sessions, const ReplayOptions& options) {
  bool behind_state = false;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const Recording& session = sessions[i];
    const std::string name = session.root.string();
    const bool has_state = begins_with_state(session);
    const bool begins_log = session.device && (i == 0 || !sessions[i - 1].device || sessions[i - 1].device->last);
    if (begins_log && !has_state && behind_state)
      throw InputError(name +
                       ": begins without a state, behind a log that begins with one: expected logs in the order of "
                       "time; with --without-state their data alone are replayed");
    behind_state |= has_state;
    if (i == 0 || !has_state) continue;
    if (!options.calibrate)
      throw InputError(name +
                       ": begins with a state that calibrations made: expected --without-state beside "
                       "--no-calibration, or this log alone");
    restore_logged(session, make_core(options.profile, options.core).get());
  }
}

void begin_device(const Recording& first, const ReplayOptions& options, Core* core) {
  if (begins_with_state(first)) return restore_logged(first, core);
  StateFile* state = options.state;
  if (!state || state->is_new()) return;
  const std::string name = state->path().string();
  if (state->profile != options.profile)
    throw InputError(name + ": saved with --profile " + state->profile + "; expected the same, found " +
                     options.profile);
  try {
    core->restore(&state->flash);
  } catch (const InputError& error) {
    throw InputError(name + ": " + error.what());
  }
}

void expect_left_state(const Recording& session, const ReplayOptions& options, Core* core) {
  if (!begins_with_state(session)) return;
  const std::unique_ptr<Core> logged = make_core(options.profile, options.core);
  restore_logged(session, logged.get());
  if (stored(logged.get()) == stored(core)) return;
  throw InputError(session.root.string() +
                   ": begins with another state than the logs before it leave: expected the next log of the same "
                   "device, found one after a missing or torn log; replay it alone, from its own state");
}

}  // namespace host
