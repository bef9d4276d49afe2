// The subcommand `segcal simulate`.
#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "../commands.h"
#include "../csv.h"
#include "../files/output_run.h"
#include "../render/render_images.h"
#include "effect_options.h"
#include "fault_kinds.h"
#include "scenarios.h"
#include "simulate.h"
#include "simulate_help.h"

namespace host {
namespace {

struct Command {
  SimulationOptions options;
  render::ImageOptions images;
  std::filesystem::path out;
  std::string distortion = "fov", readout = "rows";
  sim::EffectOptions effects;
  std::vector<const sim::FaultKind*> spoil;
};

std::string scenario_help() {
  std::string text = "motion:";
  for (const sim::Scenario& scenario : sim::scenarios())
    text += std::string("\n  ") + scenario.name + ": " + scenario.description;
  return text;
}

std::vector<std::string> scenario_names() {
  std::vector<std::string> names;
  for (const sim::Scenario& scenario : sim::scenarios()) names.emplace_back(scenario.name);
  return names;
}

/// The output must not fall on what is read.
void check_output(const Command& command) {
  namespace fs = std::filesystem;
  const fs::path out = fs::weakly_canonical(command.out);
  for (const fs::path& input : {command.options.trajectory_file, command.options.imu_file, command.effects.model}) {
    if (input.empty()) continue;
    const fs::path inside = fs::weakly_canonical(input).lexically_relative(out);
    if (!inside.empty() && *inside.begin() != "..")
      throw InputError("--out " + command.out.string() + ": expected another folder than the one that holds " +
                       input.string());
  }
}

void report(const Command& command, const SimulationResult& result) {
  std::size_t points = 0, frames = 0;
  for (const CameraData& camera : result.recording.cameras) {
    frames += camera.frames.size();
    for (const Frame& frame : camera.frames) points += frame.points.size();
  }
  std::cerr << "wrote " << command.out.string() << ": " << result.recording.imu.samples.size() << " IMU samples, "
            << frames;
  if (result.with_images)
    std::cerr << " images; next: segcal track " << command.out.string() << '\n';
  else
    std::cerr << " frames, " << points / std::max<std::size_t>(frames, 1) << " tracks per frame\n";
}

void write_images(const Command& command, const SimulationResult& result) {
  const auto began = std::chrono::steady_clock::now();
  render::write_images(result, command.options, command.images, command.out, [&](std::size_t done, std::size_t all) {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
    if (done % 20 == 0 || done == all)
      std::cerr << "\rrendering " << done << " of " << all << " images, "
                << static_cast<int>(1e3 * spent.count() / static_cast<double>(done)) << " ms each"
                << (done == all ? "\n" : "") << std::flush;
  });
}

void run(const Command& command) {
  check_output(command);
  expect_output_folder(command.out, "simulate", true);
  if (command.options.images)
    render::read_photographs(command.images.photographs);  // complain before anything is written
  SimulationResult result = simulate(command.options, [](double share) {
    std::cerr << "\rsimulating " << static_cast<int>(100 * share) << " %" << std::flush;
  });
  std::cerr << "\rsimulating 100 %\n";
  for (const sim::FaultKind* kind : command.spoil) {
    kind->spoil(result.recording, command.options.seed);
    result.effects.push_back({kind->name, {}});
  }
  OutputRun files(command.out, "simulate");
  write_simulation(result, command.out);
  if (command.options.images) write_images(command, result);
  files.finish();
  report(command, result);
}

void add_motion_options(CLI::App& app, Command& command) {
  SimulationOptions& options = command.options;
  app.add_option("--scenario", options.scenario, scenario_help())
      ->check(CLI::IsMember(scenario_names()))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "length, s")->capture_default_str();
  app.add_option("--seed", options.seed, "motion, scene, biases and noise")->capture_default_str();
  app.add_option("--trajectory", options.trajectory_file,
                 "follow recorded poses instead of a scenario (groundtruth.csv)");
  app.add_option("--imu", options.imu_file, "take real IMU samples of that trajectory (imu.csv)");
}

void add_device_options(CLI::App& app, Command& command) {
  SimulationOptions& options = command.options;
  app.add_option_function<std::uint64_t>(
      "--device-seed", [&options](std::uint64_t seed) { options.device_seed = seed; },
      "seed of the simulated device (default: --seed)");
  app.add_option("--device-scale", options.device_scale, "factor on the scatter of devices, 0 for the nominal one")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  app.add_option("--cameras", options.cameras, "1 or 2")->check(CLI::Range(1, 2))->capture_default_str();
  app.add_flag("!--no-matches", options.stereo_matches, "with two cameras: no corner has the same track id in both");
  app.add_option("--distortion", command.distortion, "lens model")
      ->check(CLI::IsMember({"fov", "radtan", "equidistant"}))
      ->capture_default_str();
  app.add_option(
         "--readout", command.readout,
         "what rolling_shutter exposes one after another: rows; or columns, as in the images of a phone held upright")
      ->check(CLI::IsMember({"rows", "columns"}))
      ->capture_default_str();
}

void set_track_noise(const std::string& what, sim::TrackOptions* tracks) {
  if (what == "white") return;
  if (what == "drift") {
    const sim::TrackOptions drifting = sim::drifting_tracks();
    tracks->pixel_noise_px = drifting.pixel_noise_px;
    tracks->walk_px_per_sqrt_s = drifting.walk_px_per_sqrt_s;
    return;
  }
  const nlohmann::json result = nlohmann::json::parse(read_file(what), nullptr, false);
  try {
    tracks->pixel_noise_px = result.at("noise").at("track_white_px").get<double>();
    tracks->walk_px_per_sqrt_s = result.at("noise").at("track_walk_px_per_sqrt_s").get<double>();
  } catch (const nlohmann::json::exception&) {
    throw InputError("--track-noise " + what +
                     ": expected white, drift or a result.json with `noise`, as segcal replay writes it");
  }
}

void add_sensor_options(CLI::App& app, Command& command) {
  SimulationOptions& options = command.options;
  ImuNoise& noise = options.imu_noise;
  const CLI::Range positive(0.0, 1e3);
  app.add_option("--tracks", options.tracks.count, "tracks at a time and camera")->capture_default_str();
  app.add_option("--pixel-noise", options.tracks.pixel_noise_px, "standard deviation per axis, px")
      ->capture_default_str();
  app.add_option_function<std::string>(
      "--track-noise", [&options](const std::string& what) { set_track_noise(what, &options.tracks); },
      "white: --pixel-noise alone; drift: as the corner tracks of a real camera, most of it a random walk along the "
      "track (0.1 px and 0.9 px/sqrt(s)); or the result.json of a replay: what its tracks showed");
  app.add_flag("--exposures", options.exposures,
               "write cam0/exposure.csv, exposures of 2 to 20 ms as a control chooses them, also without the effect "
               "exposure_offset; images always have it");
  app.add_option("--rate-camera", options.camera_rate_hz, "Hz")->capture_default_str();
  app.add_option("--rate-imu", noise.rate_hz, "Hz")->capture_default_str();
  app.add_option("--gyro-noise", noise.gyro_noise_density, "rad/s/sqrt(Hz)")->check(positive)->capture_default_str();
  app.add_option("--gyro-walk", noise.gyro_random_walk, "rad/s^2/sqrt(Hz)")->check(positive)->capture_default_str();
  app.add_option("--accel-noise", noise.accel_noise_density, "m/s^2/sqrt(Hz)")->check(positive)->capture_default_str();
  app.add_option("--accel-walk", noise.accel_random_walk, "m/s^3/sqrt(Hz)")->check(positive)->capture_default_str();
}

void add_image_options(CLI::App& app, Command& command) {
  render::SensorOptions& sensor = command.images.sensor;
  app.add_flag("--images", command.options.images,
               "images instead of tracks: camN/data.csv and camN/data, as EuRoC has them. "
               "A room of textured planes with furniture,\n"
               "through the lens of --distortion. "
               "A stamp is the middle of the exposure, with rolling_shutter that of the middle row");
  app.add_option("--exposure", sensor.exposure_s,
                 "usual exposure time, s; the exposure control goes from half of it to twice")
      ->check(CLI::Range(0.0, 0.1))
      ->capture_default_str();
  app.add_option("--grey-noise", sensor.noise_grey,
                 "noise of the image sensor at a grey value of 128: standard deviation, grey values")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  app.add_option("--lens-blur", sensor.lens_blur_px, "standard deviation of the lens' point spread, px")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_flag("!--fixed-exposure", sensor.control_exposure, "no exposure control: bright walls stay bright");
  app.add_option("--photographs", command.images.photographs,
                 "folder of the photographs on the walls (default: those that host_tools/setup.sh installs)");
}

}  // namespace

void add_simulate_command(CLI::App& app, int& exit_code) {
  CLI::App* const sub = app.add_subcommand("simulate", simulate_explanation);
  sub->footer(simulate_examples);
  const auto command = std::make_shared<Command>();
  sub->add_option("--out", command->out, "folder of the new recording")->required();
  add_motion_options(*sub, *command);
  add_device_options(*sub, *command);
  add_sensor_options(*sub, *command);
  add_image_options(*sub, *command);
  sim::add_effect_options(*sub, &command->effects);
  sub->callback([command, &exit_code] {
    command->options.distortion = distortion_from_name(command->distortion);
    command->options.reads_columns = command->readout == "columns";
    command->spoil = sim::take_effects(command->effects, &command->options);
    run(*command);
    exit_code = 0;
  });
}

}  // namespace host
