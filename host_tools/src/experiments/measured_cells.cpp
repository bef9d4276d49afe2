#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <sstream>

#include "angles.h"
#include "commands.h"
#include "experiments/measured.h"
#include "render/render_images.h"
#include "replay/replay.h"
#include "segcal/segcal.h"
#include "simulate/device.h"
#include "simulate/effects_camera.h"
#include "simulate/random.h"

namespace host::experiments {
namespace {

namespace fs = std::filesystem;
using Truth = std::map<std::string, double>;

/// Gone when the cell is: a minute of images is half a gigabyte.
class ScratchFolder {
 public:
  ScratchFolder() : path_(fs::temp_directory_path() / ("segcal_measured_" + std::to_string(::getpid()))) {
    fs::remove_all(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// `segcal track ARGUMENTS`, in this process and without its
/// lines: the study must go the user's way, not one of its own.
void track(std::vector<std::string> arguments) {
  std::ostringstream unread;
  std::streambuf *const out = std::cout.rdbuf(unread.rdbuf()), *const err = std::cerr.rdbuf(unread.rdbuf());
  const auto restore = [&] {
    std::cout.rdbuf(out);
    std::cerr.rdbuf(err);
  };
  try {
    CLI::App app("segcal");
    int exit_code = 0;
    add_track_command(app, exit_code);
    arguments.insert(arguments.begin(), "track");
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 takes them
    app.parse(arguments);
  } catch (...) {
    restore();
    throw;
  }
  restore();
}

Truth truth_of(const Calibration& calibration, bool with_imu) {
  Truth truth;
  for (const sim::NamedParameter& p : sim::named_parameters(calibration, with_imu)) truth[p.name] = p.value;
  return truth;
}

/// Calibrates, and sets what is released against what is known of the truth.
Json judged(const Recording& recording, const Calibration& start, const Truth& truth, std::uint32_t effects = 0) {
  ReplayOptions options;
  options.core.calibration = start;
  options.core.noise = recording.imu.noise;
  options.core.effects = effects;
  options.corner_noise = CornerNoise::shown;
  options.review = true;  // what `segcal replay` answers, not what its device does
  const ReplayResult replayed = replay({recording}, options);
  const CoreResult& r = replayed.result;
  Json entries = Json::array();
  double largest = 0;
  std::string of;
  for (const CoreParameter& p : r.parameters) {
    const auto known = truth.find(p.name);
    if (known == truth.end() || p.verdict == "fixed") continue;
    const double z = (p.value - known->second) / p.sigma;
    entries.push_back({{"name", p.name}, {"value", p.value}, {"sigma", p.sigma}, {"truth", known->second}, {"z", z}});
    if (std::abs(z) <= largest) continue;
    largest = std::abs(z);
    of = p.name;
  }
  return {{"status", r.status},
          {"chi2_per_dof", r.dof > 0 ? r.chi2 / r.dof : 0},
          {"segments", r.segments},
          {"frames", recording.cameras[0].frames.size()},
          {"frames_used", replayed.trajectory.size()},
          {"entries", entries},
          {"largest", largest},
          {"largest_of", of},
          {"wrong", r.status == "calibrated" && largest > wrong_sigmas}};
}

/// As the makers state them: ADIS16448 in EuRoC's sensor.yaml, BMI160 in TUM-VI's imu_config.yaml.
ImuNoise published_noise(const std::string& sequence) {
  if (sequence.rfind("tumvi", 0) == 0) return {200, 1.6e-4, 2.2e-5, 2.8e-3, 8.6e-4};
  return {200, 1.6968e-4, 1.9393e-5, 2.0e-3, 3.0e-3};
}

Calibration disturbed(Calibration calibration, std::uint64_t start, double factor) {
  sim::Random random(start, sim::Stream::device);
  const auto direction = [&random] {
    const double z = random.uniform(-1, 1), a = random.uniform(-pi, pi), r = std::sqrt(1 - z * z);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), z);
  };
  for (CameraCalibration& camera : calibration.cameras) {
    const double a = random.uniform(-pi, pi);
    camera.intrinsics.head<2>() *= 1 + factor * (random.uniform() < 0.5 ? -0.02 : 0.02);
    camera.intrinsics.tail<2>() += factor * 10 * Eigen::Vector2d(std::cos(a), std::sin(a));
    camera.distortion = {-0.24, 0.05, 0, 0};
    camera.R_CI = Eigen::AngleAxisd(factor * 1.7 * rad_per_deg, direction()).toRotationMatrix() * camera.R_CI;
    camera.p_CI += factor * 0.027 * direction();
  }
  return calibration;
}

}  // namespace

Json calibrate_rendered(const Json& parameters) {
  SimulationOptions options;
  options.scenario = parameters.at("scenario");
  options.seconds = parameters.at("seconds");
  options.seed = parameters.at("seed");
  options.camera_rate_hz = parameters.at("rate_hz");
  options.images = true;
  const double line_delay = parameters.at("line_delay_s");
  if (line_delay != 0) options.effects.push_back(std::make_shared<sim::RollingShutter>(line_delay));
  const ScratchFolder scratch;
  const SimulationResult session = simulate(options);
  write_simulation(session, scratch.path());
  render::write_images(session, options, {}, scratch.path());
  track({scratch.path().string()});
  Truth truth = truth_of(session.truth, true);
  truth["rolling_shutter.line_delay"] = line_delay;
  return judged(read_recording(scratch.path(), 1), session.nominal, truth,
                line_delay != 0 ? static_cast<unsigned>(SEGCAL_EFFECT_ROLLING_SHUTTER) : 0u);
}

Json calibrate_imu_gt(const Json& parameters) {
  const std::string sequence = parameters.at("sequence");
  const fs::path folder = fs::path(parameters.at("data").get<std::string>()) / "imu_gt" / sequence;
  SimulationOptions options;
  options.seconds = parameters.at("seconds");
  options.seed = parameters.at("seed");
  options.imu_noise = published_noise(sequence);
  options.trajectory_file = folder / "groundtruth.csv";
  const bool real = parameters.at("real_imu");
  if (real) options.imu_file = folder / "imu.csv";
  const SimulationResult session = simulate(options);
  // The truth of a real IMU is not known: it was calibrated in
  // the factory or by the data's makers, which is what 1 means.
  Json out = judged(session.recording, session.nominal, truth_of(session.truth, !real));
  return out;
}

Json calibrate_euroc(const Json& parameters) {
  const fs::path data = fs::path(parameters.at("data").get<std::string>()) / "euroc_mh01";
  const Calibration published = find_calibration(data, {}, 1);
  const Calibration start = disturbed(published, parameters.at("start"), parameters.at("factor"));
  const ScratchFolder scratch;
  const fs::path start_file = scratch.path() / "start" / "camchain-imucam.yaml", tracked = scratch.path() / "tracked";
  write_camchain(start_file, start);
  track({data.string(), "--calib", start_file.string(), "--out", tracked.string(), "--cameras", "1"});
  return judged(read_recording(tracked, 1), start, truth_of(published, false));
}

}  // namespace host::experiments
