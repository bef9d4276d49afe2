#include "replay/begin_device.h"

namespace host {
namespace {

void restore(const std::string& name, FlashImage* flash, Core* core) {
  try {
    core->restore(flash);
  } catch (const InputError& error) {
    throw InputError(name + ": " + error.what());
  }
}

void restore_logged(const Recording& session, Core* core) {
  FlashImage flash{session.device->state};
  restore(session.root.string() + ": begins with a device's state", &flash, core);
}

}  // namespace

bool begins_with_state(const Recording& session) { return session.device && !session.device->state.empty(); }

void begin_device(const Recording& first, const ReplayOptions& options, Core* core) {
  if (begins_with_state(first)) return restore_logged(first, core);
  StateFile* state = options.state;
  if (!state || state->is_new()) return;
  const std::string name = state->path().string();
  if (state->profile != options.profile)
    throw InputError(name + ": saved with --profile " + state->profile + "; expected the same, found " +
                     options.profile);
  restore(name, &state->flash, core);
}

void expect_left_state(const Recording& session, const ReplayOptions& options, const Core& core) {
  if (!begins_with_state(session)) return;
  const std::unique_ptr<Core> stored = make_core(options.profile, options.core);
  restore_logged(session, stored.get());
  if (stored->result_hash() == core.result_hash()) return;
  throw InputError(session.root.string() +
                   ": begins with another state than the logs before it leave: expected the next log of the same "
                   "device, found one after a missing or torn log; replay it alone, from its own state");
}

}  // namespace host
