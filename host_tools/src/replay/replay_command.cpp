// segcal replay: recordings in, calibration out.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iostream>

#include "clock/clock_search.h"
#include "commands.h"
#include "csv.h"
#include "device_log/device_log.h"
#include "files/output_run.h"
#include "files/sha256.h"
#include "replay/config_file.h"
#include "replay/model_file.h"
#include "replay/replay_state.h"
#include "replay/result_files.h"
#include "replay/sessions.h"
#include "replay/words.h"

namespace host {
namespace {

struct Arguments {
  std::vector<std::string> recordings;
  std::string calibration, out, model, config, strategy, verify_hash, device_id, state;
  std::vector<std::string> effects;
  int cameras = 1;
  bool json = false, no_calibration = false, keep_outdated = false, hash = false, smooth_stamps = false, keep_clock = false;
  ReplayOptions replay;
  std::vector<CLI::Option*> of_device;  ///< what a device log says itself
  CLI::Option *profile = nullptr, *pixel_sigma = nullptr, *track_walk = nullptr;
};

/// One line that counts on a terminal, a line per quarter in a log.
void show_progress(double fraction) {
  static int last = -1;
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const int step = terminal ? 1 : 25, percent = static_cast<int>(100 * fraction) / step * step;
  if (percent == last) return;
  last = percent;
  std::cerr << (terminal ? "\r" : "") << "replay " << percent << " %" << (!terminal || percent == 100 ? "\n" : "") << std::flush;
}

/// "5 of 12 segments kept, 30 in epochs"; those of a state's earlier sessions are not among the 12.
std::string words_on_segments(const ReplayResult& r, bool went_on) {
  int condensed = 0;
  for (const CoreEpoch& e : r.result.epochs) condensed += e.segments;
  const std::string kept = std::to_string(r.result.segments), scored = std::to_string(r.segments.size());
  return (went_on ? kept + " segments kept, " + scored + " scored in this run" : kept + " of " + scored + " segments kept") +
         (condensed > 0 ? ", " + std::to_string(condensed) + " in epochs" : "");
}

void print_summary(const ReplayResult& r, bool went_on) {
  const CoreResult& c = r.result;
  for (std::size_t i = 0; r.passes.size() > 1 && i < r.passes.size(); ++i) std::printf("%s\n", in_words(r.passes[i], i + 1).c_str());
  if (!r.cause.empty()) std::printf("not calibrated: %s\n", r.cause.c_str());
  for (const Suspect& s : r.health.suspects) {
    if (r.cause.find(s.words) == std::string::npos) std::printf("suspect: %s\n", s.words.c_str());
  }
  for (const Note& n : r.health.notes) {
    if (r.cause.find(n.words) == std::string::npos) std::printf("note: %s\n", n.words.c_str());
  }
  const std::vector<std::string> names = parameter_names(c, r.calibration);
  for (const CoreChange& change : c.changes) {
    if (!change.open || r.cause.empty()) std::printf("note: %s\n", change_words(change, c).c_str());
  }
  std::printf("%s: %s, chi2/dof %.3f, reprojection rms %.2f px (median %.2f px), %d iterations\n",
              c.status.c_str(), words_on_segments(r, went_on).c_str(), c.dof > 0 ? c.chi2 / c.dof : 0.0, c.reprojection_rms_px,
              c.reprojection_median_px, c.iterations);
  for (const ReplayCalibration& done : r.calibrations) {
    if (done.by_targets) std::printf("targets reached at %.2f s with %d segments: %s\n", 1e-9 * static_cast<double>(done.t_ns),
                                     done.segments, done.status.c_str());
  }
  std::printf("%-26s %14s %12s %-10s %14s  %s\n", "parameter", "value", "sigma", "unit", "initial", "verdict");
  for (const CoreParameter& p : c.parameters) {
    std::printf("%-26s %14.7g %12.3g %-10s %14.7g  %s\n", p.name.c_str(), p.value, p.sigma, p.unit.c_str(), p.initial,
                p.verdict.c_str());
  }
  for (const CoreDirection& d : c.unobservable) std::printf("%s\n", in_words(d, names).c_str());
  std::printf("state_bytes %zu (segment %zu, workspace %zu); VIO %.2f ms per frame (p95 %.2f), calibration %.0f ms\n",
              r.memory.state_bytes, r.memory.segment_bytes, r.memory.workspace_bytes, r.timing.vio_ms_median,
              r.timing.vio_ms_p95, r.timing.calibrate_ms);
}

/// A device's log is replayed as the device was: its configuration, and its capacities if they are not chosen otherwise.
void take_device(const std::vector<Recording>& sessions, Arguments* a) {
  const DeviceSession& device = *sessions.front().device;
  for (const CLI::Option* option : a->of_device) {
    if (option->count() > 0) {
      throw InputError(option->get_name() +
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
    throw InputError(sessions.front().root.string() + ": expected the capacities of profile mcu, mobile or host, found others; "
                     "--profile chooses one, and the bits will differ");
  }
  a->replay.profile = device.profile;
}

std::vector<Recording> sessions_of(Arguments* a) {
  const bool log = is_device_log(a->recordings.front());
  if (log && a->calibration.empty()) {
    const DeviceLog front = read_device_log(a->recordings.front());
    a->cameras = static_cast<int>(front.calibration.cameras.size());
    a->replay.core.pixel_sigma = front.pixel_sigma;
  }
  std::vector<Recording> sessions = read_sessions(a->recordings, a->cameras, a->smooth_stamps);
  if (log && a->calibration.empty()) {
    take_device(sessions, a);
  } else {
    for (Recording& session : sessions) session.cameras.resize(static_cast<std::size_t>(a->cameras));
  }
  return sessions;
}

/// Our hash against the device's: those in the log at their places, or the last one of another file against the end's.
/// Prints a line where they differ.
bool same_hash(const Arguments& a, const ReplayResult& result) {
  std::vector<HashCheck> checks = result.hash_checks;
  if (std::find(a.recordings.begin(), a.recordings.end(), a.verify_hash) == a.recordings.end()) {
    checks = {{read_hashes(a.verify_hash).back(), result.result_hash}};
  }
  if (checks.empty()) throw InputError(a.verify_hash + ": expected a result hash in the log (segcal_log_hash), found none");
  for (std::size_t i = 0; i < checks.size(); ++i) {
    if (checks[i].expected == checks[i].found) continue;
    std::cerr << "segcal: " << a.verify_hash << ": result hash " << i + 1 << " of " << checks.size() << ": expected "
              << hash_text(checks[i].expected) << ", found " << hash_text(checks[i].found) << std::endl;
    return false;
  }
  return true;
}

/// Where the result comes from: logs, device and what was chosen.
Provenance provenance_of(const Arguments& a, const std::vector<Recording>& sessions) {
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
  if (!a.config.empty()) from.configuration["config_sha256"] = sha256_of_text(read_file(a.config));
  if (!a.model.empty()) from.configuration["model_sha256"] = sha256_of_text(read_file(a.model));
  if (!a.calibration.empty()) from.configuration["calib_sha256"] = sha256_of_text(read_file(a.calibration));
  return from;
}

/// What the user states counts more than the recording, an option of its own more than the file.
void apply_config(Arguments* a, std::vector<Recording>* sessions) {
  SensorConfig config = read_config_file(a->config);
  if (a->pixel_sigma->count() > 0) config.pixel_sigma.reset();
  if (a->track_walk->count() > 0) config.track_walk.reset();
  config.apply(&a->replay.core);
  for (Recording& session : *sessions) session.imu.noise = a->replay.core.noise;
}

/// The offset that the clocks are known to have: of the model, if it has one, else of the camera chain.
double stated_offset(const Arguments& a, EffectChoice* choice) {
  const double of_model = choice->value("time_offset.t_d");
  return of_model != 0 ? of_model : a.replay.core.calibration.cameras.front().timeshift_cam_imu;
}

/// Moves all camera stamps to the IMU's clock: by the offset that is stated and, where the images and the gyroscope say another
/// one, by that, which is then estimated on. Returns the offset of the last session, from which the effect counts.
double align_clocks(Arguments* a, EffectChoice* choice, std::vector<Recording>* sessions) {
  const double stated = stated_offset(*a, choice);
  double offset = stated;
  for (Recording& session : *sessions) {
    if (session.device) return 0;  // a device's bits are the device's
    offset = stated;
    if (!a->keep_clock) {
      const ClockSearch found = search_clock(session, a->replay.core.calibration.cameras.front(), stated);
      a->replay.clocks.push_back(found);
      if (found.differs_from(stated)) {
        offset = found.offset_s;
        std::cerr << "segcal: " << session.root.string() << ": " << found.words << "; time_offset is estimated from there" << std::endl;
        choice->enable("time_offset");
      }
    }
    shift_frames(offset, &session);
  }
  if (choice->enabled("time_offset")) choice->set("time_offset.t_d", 0);
  return offset;
}

/// The effect's value as people and files count it: from the stamps as they are in the recording.
void count_offset_from_recording(double offset, ReplayResult* result) {
  const auto add = [offset](std::vector<CoreParameter>* parameters) {
    double value = offset;
    for (CoreParameter& p : *parameters) {
      if (p.name != "time_offset.t_d") continue;
      p.initial += offset;
      value = p.value += offset;
    }
    return value;
  };
  const double total = add(&result->result.parameters);
  for (std::size_t i = 0; i < result->result.mean.size() && i < result->result.parameters.size(); ++i) {
    if (result->result.parameters[i].name == "time_offset.t_d") result->result.mean[i] += offset;
  }
  for (ReplayCalibration& c : result->calibrations) add(&c.parameters);
  if (result->result.status != "calibrated") return;  // the calibration is the one that it started with
  for (CameraCalibration& camera : result->calibration.cameras) camera.timeshift_cam_imu = total;
}

int run(Arguments a) {
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
  if (a.replay.passes > 1 && sessions.front().device) throw InputError("--passes: expected recordings, found a device log, whose calls are the device's");
  if (a.replay.passes > 1 && a.replay.core.multi_session) throw InputError("--passes: expected --strategy single; with multi, segments of each pass would count again");
  a.replay.calibrate = !a.no_calibration;
  a.replay.core.has_temperature = true;
  for (const Recording& r : sessions) a.replay.core.has_temperature &= r.imu.has_temperature;
  EffectChoice choice;
  if (!a.model.empty()) choice = read_model(a.model);
  for (const std::string& name : a.effects) choice.enable(name);
  const double offset = align_clocks(&a, &choice, &sessions);
  choice.apply(&a.replay.core);
  a.replay.review = !sessions.front().device && !a.replay.joint_ekf && a.replay.calibrate;
  if (a.keep_outdated) a.replay.core.outdated_level = -1;
  a.replay.progress = show_progress;
  if (!a.verify_hash.empty()) read_hashes(a.verify_hash);  // a file without one is found out before the work
  ReplayResult result = replay(sessions, a.replay);
  if (!sessions.front().device) count_offset_from_recording(offset, &result);
  Provenance from = provenance_of(a, sessions);
  if (state) from.earlier_logs = seen_logs(*state);
  write_result_files(a.out, result, from, sessions.back().truth);
  if (state) write_state(sessions, from.logs, state.get());  // last: a run that was stopped is run again from the same state
  if (a.json) {
    std::cout << result_json(result, from).dump(1) << std::endl;
  } else {
    print_summary(result, from.earlier_logs && !from.earlier_logs->empty());
    if (a.hash) std::printf("result_hash %s\n", hash_text(result.result_hash).c_str());
  }
  if (!a.verify_hash.empty()) return same_hash(a, result) ? 0 : 1;
  if (a.no_calibration) return 0;
  return result.calibrated && result.result.status == "calibrated" ? 0 : 1;
}

void add_files(CLI::App* sub, Arguments* a) {
  sub->add_option("recordings", a->recordings,
                  "recordings in ASL layout (REC/mav0/...) or device logs (*.segcal); several are sessions in order")->required();
  sub->add_option("--calib", a->calibration, "starting calibration, Kalibr's camchain-imucam.yaml (default: the recording's own)");
  sub->add_option("--out", a->out,
                  "folder for result.json, calibration.jsonl, camchain-imucam.yaml, imu.yaml, trajectory.tum, model.yaml, config.yaml, kept_segments.json")->required();
  sub->add_option("--state", a->state,
                  "what the device keeps over power-off: go on where the last replay with this file ended, and save to it (made where there is none)")
      ->type_name("FILE");
  sub->add_option("--device-id", a->device_id, "name of the device in result.json (default: REC/device.yaml's device_id)");
  sub->add_flag("--json", a->json, "print result.json on standard output");
}

/// What is kept, and when a calibration is due.
void add_database_options(CLI::App* sub, Arguments* a) {
  CoreOptions& core = a->replay.core;
  a->profile = sub->add_option("--profile", a->replay.profile,
                               "capacities of the core, as compiled for firmware: mcu, mobile, host; mobile_double: mobile in double "
                               "precision, to check float; of a device log: the device's")->capture_default_str();
  sub->add_option("--metric", core.metric,
                  "what makes a segment informative: A, D, E or random; set_d: the set that tells most together")->capture_default_str();
  sub->add_option("--segments", core.segments, "segments to keep in the database")->capture_default_str()->check(CLI::PositiveNumber);
  sub->add_option("--segment-seconds", core.segment_s, "length of a segment, s")->capture_default_str()->check(CLI::Range(1.0, 30.0));
  sub->add_flag("--adaptive-segments", core.adaptive_segments,
                "end quiet segments from half that length on, let lively ones go on up to twice");
  sub->add_option("--strategy", a->strategy, "single: each session starts with an empty database; multi: the best of all stay (default: single; with --condense or --state multi)")
      ->check(CLI::IsMember({"single", "multi"}));
  sub->add_option("--seed", core.seed, "of the random metric")->capture_default_str();
  sub->add_option("--trigger-sigma", core.trigger_fraction,
                  "calibrate in between, as soon as all predicted sigmas are below this fraction of the prior's; 0: at the end only")
      ->capture_default_str()->check(CLI::Range(0.0, 0.99));
  sub->add_flag("--condense", core.condense, "condense segments that end after a release into epochs, so that nothing that was seen is lost; sessions follow one another (--strategy multi)");
  sub->add_option("--passes", a->replay.passes,
                  "over the recordings up to so many times, each from the calibration that the one before gave, until no entry moves by 0.1 of its sigma; "
                  "segments and the prior stay those of one pass from the start that was given")
      ->capture_default_str()->check(CLI::Range(1, 20));
  sub->add_flag("--keep-outdated", a->keep_outdated, "keep segments that newer ones contradict: theta is taken as constant");
  sub->add_flag("--no-calibration", a->no_calibration, "odometry only: the trajectory with the starting calibration");
}

/// What the core believes of the sensors.
void add_model_options(CLI::App* sub, Arguments* a) {
  CoreOptions& core = a->replay.core;
  sub->add_option("--cameras", a->cameras, "cameras to use, cam0 first")->capture_default_str()->check(CLI::Range(1, 2));
  sub->add_option("--config,--priors", a->config,
                  "config.yaml: priors of the starting calibration, gravity, noise of IMU and corners; see below. OUT/config.yaml holds what was used")
      ->type_name("FILE");
  a->pixel_sigma = sub->add_option("--pixel-sigma", core.pixel_sigma, "stated noise of a tracked corner per axis, px")
      ->capture_default_str()->check(CLI::PositiveNumber);
  sub->add_flag("--smooth-stamps", a->smooth_stamps,
                "stamps were taken in callbacks: replace each by a robust line through those of one second before and after it");
  sub->add_flag("--keep-clock", a->keep_clock,
                "do not look for the camera clock's offset: it is the camera chain's timeshift_cam_imu, or the model's");
  a->track_walk = sub->add_option("--track-walk", core.track_walk, "random walk of a corner's error along its track per axis, px/sqrt(s)")
      ->capture_default_str()->check(CLI::Range(0.0, 100.0));
  sub->add_flag("--estimate-track-noise", a->replay.estimate_track_noise,
                "replay twice: the second time with the white noise and the walk that the first one's tracks show")
      ->excludes("--pixel-sigma")->excludes("--track-walk");
  sub->add_option("--enable", a->effects,
                  "effect to estimate beside the calibration, as time_offset; repeatable. All of them: see below")
      ->allow_extra_args(false);
  sub->add_option("--model", a->model, "model.yaml: effects to estimate, with the values to start from");
  sub->add_flag("--hold-calibration", core.hold_calibration,
                "the odometry runs with the calibration as it is, without estimates of its own");
  sub->add_flag("--joint-ekf", a->replay.joint_ekf,
                "for comparison: no segments, the filter's own estimate of the calibration is the result");
}

void add_hash_options(CLI::App* sub, Arguments* a) {
  sub->add_flag("--hash", a->hash, "print one number over all bits of theta, its sigmas, the trajectory and the kept segments");
  sub->add_option("--verify-hash", a->verify_hash,
                  "compare that number with the one in FILE: a device log (at the places where the device wrote it), or a text that "
                  "holds 'result_hash' and the number")->type_name("FILE");
}

std::string replay_help() {
  return R"(Example:
  segcal replay rec --calib start.yaml --out out && segcal report out

Verdicts: observed, the sigma fell below 0.3 of the prior's; weak, below 0.5; fixed, the data cannot tell: the parameter
stays where it was.

The odometry estimates extrinsics, intrinsics and the IMU's scales, misalignments and rotation as states of its filter in
every run, from priors of its own (4 % of f, 10 px, 0.05 per lens coefficient; 0.01 gyroscope, 0.02 accelerometer), so that
a wrong start does not spoil the trajectory. That estimate stays inside the filter; the result comes from the segments and
replaces it. With --joint-ekf the filter has the result's prior and the stated pixel noise, its estimate at the end of a
session is the result, and the next session goes on from it with all of its information.

With --state each run is the next session of the same device: two runs give the bits of one run over both recordings. The file
holds the kept segments, epochs and calibration; the options, priors and start must be those of the run that made it. OUT holds the
calibration from all that the device remembers, and the trajectory and segments of this run:
  segcal replay monday --state device.state --out mon
  segcal replay tuesday --state device.state --calib monday/camchain-imucam.yaml --out tue

A device log (made with segcal/log.h, or by segcal convert) is replayed with the configuration in it and the calls that the
device made, so that it gives the device's bits:
  segcal replay flight.segcal --out out --verify-hash flight.segcal

)" + config_help() + "\n" + effects_help() + R"(
Exit code 1: the result is not `calibrated` (too little motion, or the model does not fit); with --verify-hash: the hash is
another one.)";
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  CLI::App* sub = app.add_subcommand("replay", "run recordings through the core: odometry, segments, calibration");
  add_files(sub, a.get());
  add_database_options(sub, a.get());
  add_model_options(sub, a.get());
  add_hash_options(sub, a.get());
  for (const char* name : {"--metric", "--segments", "--segment-seconds", "--adaptive-segments", "--strategy", "--cameras", "--config", "--pixel-sigma",
                           "--track-walk", "--estimate-track-noise",
                           "--seed", "--trigger-sigma", "--hold-calibration", "--joint-ekf", "--keep-outdated"}) {
    a->of_device.push_back(sub->get_option(name));
  }
  for (const char* name : {"--joint-ekf", "--estimate-track-noise", "--no-calibration"}) sub->get_option("--state")->excludes(sub->get_option(name));
  for (const char* name : {"--joint-ekf", "--no-calibration", "--condense", "--state"}) sub->get_option("--passes")->excludes(sub->get_option(name));
  sub->footer(replay_help());
  sub->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace host
