// The options of `segcal replay` and its help.
#include "replay/config_file.h"
#include "replay/model_file.h"
#include "replay/replay_arguments.h"

namespace host {
namespace {

void add_files(CLI::App* sub, ReplayArguments* a) {
  sub->add_option("recordings", a->recordings,
                  "recordings in ASL layout (REC/mav0/...) or device logs (*.segcal); several are sessions in order")
      ->required();
  sub->add_option("--calib", a->calibration,
                  "starting calibration, Kalibr's camchain-imucam.yaml (default: the recording's own)");
  sub->add_option("--out", a->out,
                  "folder for result.json, calibration.jsonl, camchain-imucam.yaml, imu.yaml, trajectory.tum, "
                  "model.yaml, config.yaml, kept_segments.json")
      ->required();
  sub->add_option("--state", a->state,
                  "the state that the device keeps across a power cycle: continue where the last replay with this file "
                  "ended, and save to it (created if missing)")
      ->type_name("FILE");
  sub->add_flag("--without-state", a->without_state,
                "leave out the state that a device log begins with: what the log alone says");
  sub->add_option("--device-id", a->device_id,
                  "name of the device in result.json (default: REC/device.yaml's device_id)");
  sub->add_flag("--json", a->json, "print result.json on standard output");
}

/// What is kept, and when a calibration is due.
void add_database_options(CLI::App* sub, ReplayArguments* a) {
  CoreOptions& core = a->replay.core;
  a->profile = sub->add_option("--profile", a->replay.profile,
                               "capacities of the core, as compiled for firmware: mcu, mobile, host; mobile_double: "
                               "mobile in double precision, to check float; of a device log: the device's")
                   ->capture_default_str();
  sub->add_option("--metric", core.metric,
                  "how segments are rated: A, D, E or random; set_d: the most informative set as a whole")
      ->capture_default_str();
  sub->add_option("--segments", core.segments, "segments to keep in the database")
      ->default_str("8, or as many as the profile holds")
      ->check(CLI::PositiveNumber);
  sub->add_option("--segment-seconds", core.segment_s, "length of a segment, s")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 30.0));
  sub->add_flag("--adaptive-segments", core.adaptive_segments,
                "end quiet segments from half that length on, extend lively ones up to twice");
  sub->add_option("--strategy", a->strategy,
                  "single: each session starts with an empty database; multi: the best of all sessions are kept "
                  "(default: single; with --condense or --state multi)")
      ->check(CLI::IsMember({"single", "multi"}));
  sub->add_option("--seed", core.seed, "of the random metric")->capture_default_str();
  sub->add_option("--trigger-sigma", core.trigger_fraction,
                  "calibrate in between, as soon as all predicted sigmas are below this fraction of the prior's; 0: at "
                  "the end only")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 0.99));
  sub->add_flag("--condense", core.condense,
                "condense segments that end after a release into epochs, so that their information is kept; sessions "
                "follow one another (--strategy multi)");
  sub->add_option(
         "--passes", a->replay.passes,
         "over the recordings up to so many times, each from the calibration that the one before gave, until no entry "
         "moves by 0.1 of its sigma; segments and the prior stay those of one pass from the start that was given")
      ->capture_default_str()
      ->check(CLI::Range(1, 20));
  sub->add_flag("--keep-outdated", a->keep_outdated,
                "keep segments that newer ones contradict: theta is assumed constant");
  sub->add_flag("--no-calibration", a->no_calibration, "odometry only: the trajectory with the starting calibration");
}

/// What the core believes of the sensors.
void add_model_options(CLI::App* sub, ReplayArguments* a) {
  CoreOptions& core = a->replay.core;
  sub->add_option("--cameras", a->cameras, "cameras to use, cam0 first")
      ->capture_default_str()
      ->check(CLI::Range(1, 2));
  sub->add_option("--config,--priors", a->config,
                  "config.yaml: priors of the starting calibration, gravity, noise of IMU and corners; see below. "
                  "OUT/config.yaml holds the values used")
      ->type_name("FILE");
  a->pixel_sigma = sub->add_option("--pixel-sigma", core.pixel_sigma,
                                   "stated noise of a tracked corner per axis, px. Where it is not stated, here or in "
                                   "--config, and the tracks show noise other than the default, or a random walk, a "
                                   "second replay weighs them by what they show")
                       ->capture_default_str()
                       ->check(CLI::PositiveNumber);
  sub->add_flag(
      "--smooth-stamps", a->smooth_stamps,
      "for stamps taken in callbacks: replace each by a robust line through those of one second before and after it");
  sub->add_option(
         "--stamp-exposure", a->stamp_exposure,
         "K times the exposure (cam0/exposure.csv) is added to each image's stamp: 0.5 where stamps are of the "
         "exposure's start, -0.5 where they are of its end")
      ->type_name("K")
      ->check(CLI::Range(-1.0, 1.0));
  sub->add_flag(
      "--keep-clock", a->keep_clock,
      "do not search for the camera clock's offset: use the camera chain's timeshift_cam_imu, or the model's");
  a->track_walk = sub->add_option("--track-walk", core.track_walk,
                                  "random walk of a corner's error along its track per axis, px/sqrt(s)")
                      ->capture_default_str()
                      ->check(CLI::Range(0.0, 100.0));
  sub->add_flag(
         "--estimate-track-noise", a->estimate_track_noise,
         "replay twice in any case, also where the first replay refuses the calibration: the second time with the "
         "white noise and the random walk that the tracks of the first show. An effect "
         "that the first one names still counts, one without a name may pass for noise")
      ->excludes("--pixel-sigma")
      ->excludes("--track-walk");
  sub->add_option("--enable", a->effects,
                  "effect to estimate beside the calibration, as time_offset; repeatable. All of them: see below")
      ->allow_extra_args(false);
  sub->add_option("--model", a->model, "model.yaml: effects to estimate, with the values to start from");
  sub->add_flag("--hold-calibration", core.hold_calibration,
                "the odometry uses the calibration as given and does not estimate it");
  sub->add_flag("--joint-ekf", a->replay.joint_ekf,
                "for comparison: no segments, the filter's own estimate of the calibration is the result");
}

void add_hash_options(CLI::App* sub, ReplayArguments* a) {
  sub->add_flag("--hash", a->hash,
                "print one number over all bits of theta, its sigmas, the trajectory and the kept segments");
  sub->add_option("--verify-hash", a->verify_hash,
                  "compare that number with the one in FILE: a device log (at the places where the device wrote it), "
                  "or a text that holds 'result_hash' and the number")
      ->type_name("FILE");
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
session is the result, and the next session goes on from it with all of its information. It is held against the
calibration by segments, and is not called calibrated where the two disagree.

With --state each run is the next session of the same device: two runs give the bits of one run over both recordings with
--pixel-sigma. The file holds the kept segments, epochs and calibration; the options, priors and start must be those of the
run that made it. OUT holds the calibration from all that the device remembers, and the trajectory and segments of this run:
  segcal replay monday --state device.state --out mon
  segcal replay tuesday --state device.state --calib monday/camchain-imucam.yaml --out tue

A device log (made with segcal/log.h, or by segcal convert) is replayed with the configuration in it and the calls that the
device made, so that it gives the device's bits:
  segcal replay flight.segcal --out out --verify-hash flight.segcal
A log may begin with the state of a device that went on, after a session or after power-off, and is then replayed from there;
behind the log before it, the state must be what that one leaves. With --without-state it counts for itself:
  segcal replay monday.segcal tuesday.segcal --out out

)" + config_help() +
         "\n" + effects_help() + R"(
Exit code 1: the result is not `calibrated` (too little motion, or the model does not fit); with --verify-hash: the hash is
another one.)";
}

}  // namespace

void add_replay_options(CLI::App* sub, ReplayArguments* a) {
  add_files(sub, a);
  add_database_options(sub, a);
  add_model_options(sub, a);
  add_hash_options(sub, a);
  for (const char* name : {"--metric", "--segments", "--segment-seconds", "--adaptive-segments", "--strategy",
                           "--cameras", "--config", "--pixel-sigma", "--track-walk", "--estimate-track-noise", "--seed",
                           "--trigger-sigma", "--hold-calibration", "--joint-ekf", "--keep-outdated"}) {
    a->of_device.push_back(sub->get_option(name));
  }
  for (const char* name : {"--joint-ekf", "--estimate-track-noise", "--no-calibration"})
    sub->get_option("--state")->excludes(sub->get_option(name));
  for (const char* name : {"--joint-ekf", "--no-calibration", "--condense", "--state"})
    sub->get_option("--passes")->excludes(sub->get_option(name));
  sub->footer(replay_help());
}

}  // namespace host
