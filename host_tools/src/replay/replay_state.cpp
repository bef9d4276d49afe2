#include "replay/replay_state.h"

#include <algorithm>

namespace host {

void expect_new_sessions(const std::vector<Recording>& sessions, const StateFile& state) {
  std::vector<SeenLog> seen = state.logs;
  for (const Recording& session : sessions) {
    const std::string name = session.root.string();
    if (session.device)
      throw InputError("--state: expected recordings, found the device log " + name +
                       ", which begins where its device did");
    const std::string rates = sha256_of_rates(session.imu);
    const auto same =
        std::find_if(seen.begin(), seen.end(), [&rates](const SeenLog& log) { return log.imu_sha256 == rates; });
    if (same != seen.end()) {
      throw InputError(name + ": has the samples of " + same->name + ", which " + state.path().string() +
                       " has seen; counted twice, they would make the sigmas too small");
    }
    seen.push_back({name, "", rates});
  }
}

std::vector<LogIdentity> seen_logs(const StateFile& state) {
  std::vector<LogIdentity> logs;
  for (const SeenLog& log : state.logs) logs.push_back({log.name, log.sha256});
  return logs;
}

void write_state(const std::vector<Recording>& sessions, const std::vector<LogIdentity>& logs, StateFile* state) {
  for (std::size_t i = 0; i < sessions.size(); ++i)
    state->logs.push_back({logs[i].name, logs[i].sha256, sha256_of_rates(sessions[i].imu)});
  state->write();
}

}  // namespace host
