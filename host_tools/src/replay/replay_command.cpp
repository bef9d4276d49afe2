// segcal replay: recordings in, calibration out.
#include <algorithm>
#include <cstdio>
#include <iostream>

#include "commands.h"
#include "csv.h"
#include "device_log/device_log.h"
#include "files/output_run.h"
#include "files/sha256.h"
#include "replay/begin_device.h"
#include "replay/config_file.h"
#include "replay/model_file.h"
#include "replay/replay_clocks.h"
#include "replay/replay_state.h"
#include "replay/replay_summary.h"
#include "replay/result_files.h"
#include "replay/sessions.h"

namespace host {
namespace {

/// A device's log is replayed as the device was: its configuration,
/// and its capacities if they are not chosen otherwise.
void take_device(const std::vector<Recording>& sessions, ReplayArguments* a) {
  const DeviceSession& device = *sessions.front().device;
  for (const CLI::Option* option : a->of_device) {
    if (option->count() > 0) {
      throw InputError(
          option->get_name() +
          ": the log holds the device's configuration; expected --calib FILE as well, to replay it with another one");
    }
  }
  for (const Recording& session : sessions) {
    if (session.device && session.device->config != device.config) {
      throw InputError(session.root.string() + ": expected the configuration of " + sessions.front().root.string() +
                       ", found another one");
    }
  }
  a->replay.core.device_config = device.config;
  if (a->profile->count() > 0) return;
  if (device.profile.empty()) {
    throw InputError(sessions.front().root.string() +
                     ": expected the capacities of profile mcu, mobile or host, found others; --profile chooses one, "
                     "and the bits will differ");
  }
  a->replay.profile = device.profile;
}

std::vector<Recording> sessions_of(ReplayArguments* a) {
  const bool log = is_device_log(a->recordings.front());
  if (log && a->calibration.empty()) {
    const DeviceLog front = read_device_log(a->recordings.front());
    a->cameras = static_cast<int>(front.calibration.cameras.size());
    a->replay.core.pixel_sigma = front.pixel_sigma;
  }
  const bool as_device = log && a->calibration.empty();
  std::vector<Recording> sessions =
      read_sessions(a->recordings, a->cameras, a->smooth_stamps, a->stamp_exposure,
                    as_device && !a->without_state ? LoggedStates::kept : LoggedStates::left_out);
  if (as_device) {
    take_device(sessions, a);
  } else {
    for (Recording& session : sessions) session.cameras.resize(static_cast<std::size_t>(a->cameras));
  }
  return sessions;
}

/// Our hash against the device's: those in the log at their places, or the last one of another file against the end's.
/// Prints a line where they differ.
bool same_hash(const ReplayArguments& a, const ReplayResult& result) {
  std::vector<HashCheck> checks = result.hash_checks;
  if (std::find(a.recordings.begin(), a.recordings.end(), a.verify_hash) == a.recordings.end()) {
    checks = {{read_hashes(a.verify_hash).back(), result.result_hash}};
  }
  if (checks.empty())
    throw InputError(a.verify_hash + ": expected a result hash in the log (segcal_log_hash), found none");
  for (std::size_t i = 0; i < checks.size(); ++i) {
    if (checks[i].expected == checks[i].found) continue;
    std::cerr << "segcal: " << a.verify_hash << ": result hash " << i + 1 << " of " << checks.size() << ": expected "
              << hash_text(checks[i].expected) << ", found " << hash_text(checks[i].found) << std::endl;
    return false;
  }
  return true;
}

/// Where the result comes from: logs, device and what was chosen.
Provenance provenance_of(const ReplayArguments& a, const std::vector<Recording>& sessions) {
  Provenance from = device_of(a.recordings.front());
  if (!a.device_id.empty()) from.device_id = a.device_id;
  for (const std::string& log : a.recordings) {
    const std::filesystem::path path = std::filesystem::path(log).lexically_normal();
    const std::string name = path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
    from.logs.push_back({name, sha256_of_log(path, a.cameras)});
  }
  from.temperature_degC = temperature_range(sessions);
  from.configuration = configuration_json(a.replay);
  from.configuration["enable"] = a.effects;
  if (a.stamp_exposure) from.configuration["stamp_exposure"] = *a.stamp_exposure;
  if (!a.config.empty()) from.configuration["config_sha256"] = sha256_of_text(read_file(a.config));
  if (!a.model.empty()) from.configuration["model_sha256"] = sha256_of_text(read_file(a.model));
  if (!a.calibration.empty()) from.configuration["calib_sha256"] = sha256_of_text(read_file(a.calibration));
  return from;
}

/// What the user states counts more than the recording, an option of its own more than the file.
void apply_config(ReplayArguments* a, std::vector<Recording>* sessions) {
  SensorConfig config = read_config_file(a->config);
  if (a->pixel_sigma->count() > 0) config.pixel_sigma.reset();
  if (a->track_walk->count() > 0) config.track_walk.reset();
  a->states_corner_noise |= config.pixel_sigma.has_value() || config.track_walk.has_value();
  config.apply(&a->replay.core);
  for (Recording& session : *sessions) session.imu.noise = a->replay.core.noise;
}

/// Without a word about corners their tracks decide. A device does not replay, and a state goes on.
CornerNoise corner_noise_of(const ReplayArguments& a, bool of_device) {
  if (a.estimate_track_noise) return CornerNoise::estimated;
  const bool stated = a.states_corner_noise || a.pixel_sigma->count() > 0 || a.track_walk->count() > 0;
  const bool once = of_device || a.replay.state || a.replay.joint_ekf || !a.replay.calibrate;
  return stated || once ? CornerNoise::stated : CornerNoise::shown;
}

int run(ReplayArguments a) {
  expect_output_folder(a.out, "replay");
  std::unique_ptr<StateFile> state;
  if (!a.state.empty()) state = std::make_unique<StateFile>(a.state);
  a.replay.state = state.get();
  std::vector<Recording> sessions = sessions_of(&a);
  if (state) expect_new_sessions(sessions, *state);
  a.replay.core.calibration = find_calibration(a.recordings.front(), a.calibration, a.cameras);
  a.replay.core.noise = sessions.front().imu.noise;
  if (!a.config.empty()) apply_config(&a, &sessions);
  a.replay.core.multi_session = a.strategy == "multi" || (a.strategy.empty() && (a.replay.core.condense || state));
  if (a.replay.passes > 1 && sessions.front().device)
    throw InputError("--passes: expected recordings, found a device log, whose calls are the device's");
  if (a.replay.passes > 1 && a.replay.core.multi_session)
    throw InputError("--passes: expected --strategy single; with multi, segments of each pass would count again");
  a.replay.calibrate = !a.no_calibration;
  a.replay.core.has_temperature = true;
  for (const Recording& r : sessions) a.replay.core.has_temperature &= r.imu.has_temperature;
  EffectChoice choice;
  if (!a.model.empty()) choice = read_model(a.model);
  for (const std::string& name : a.effects) choice.enable(name);
  const double offset = align_clocks(&a, &choice, &sessions);
  start_line_delay(a, sessions, &choice);
  choice.apply(&a.replay.core);
  a.replay.review = !sessions.front().device && a.replay.calibrate;
  if (a.keep_outdated) a.replay.core.outdated_level = -1;
  a.replay.corner_noise = corner_noise_of(a, sessions.front().device.has_value());
  a.replay.progress = show_replay_progress;
  if (!a.verify_hash.empty()) read_hashes(a.verify_hash);  // a file without one is found out before the work
  ReplayResult result = replay(sessions, a.replay);
  if (!sessions.front().device) count_offset_from_recording(offset, &result);
  Provenance from = provenance_of(a, sessions);
  if (state) from.earlier_logs = seen_logs(*state);
  from.begins_with_state = begins_with_state(sessions.front());
  write_result_files(a.out, result, from, sessions.back().truth);
  if (state)
    write_state(sessions, from.logs, state.get());  // last: a run that was stopped is run again from the same state
  if (a.json) {
    std::cout << result_json(result, from).dump(1) << std::endl;
  } else {
    print_replay_summary(result, from.begins_with_state || (from.earlier_logs && !from.earlier_logs->empty()));
    if (a.hash) std::printf("result_hash %s\n", hash_text(result.result_hash).c_str());
  }
  if (!a.verify_hash.empty()) return same_hash(a, result) ? 0 : 1;
  if (a.no_calibration) return 0;
  return result.calibrated && result.result.status == "calibrated" ? 0 : 1;
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<ReplayArguments>();
  CLI::App* sub = app.add_subcommand("replay", "run recordings through the core: odometry, segments, calibration");
  add_replay_options(sub, a.get());
  sub->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace host
