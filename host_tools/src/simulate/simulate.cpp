#include "simulate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "device.h"
#include "exposures.h"
#include "real_imu.h"
#include "scenarios.h"
#include "scene.h"
#include "trajectory_fit.h"

namespace host {
namespace {

constexpr double imu_lead = 0.05;    // s of IMU samples before the first frame and after the last
constexpr double fit_margin = 0.35;  // s at the ends of a fitted trajectory that are left out
constexpr std::int64_t epoch_ns = 1700000000000000000;
constexpr std::uint64_t seed_step_per_camera = 1000003;

/// Where the motion comes from and when it is simulated: times in s on the trajectory's clock.
struct SimulatedSession {
  sim::Trajectory trajectory;
  std::int64_t time_zero_ns = 0;
  double first_frame = 0, last_frame = 0;
  std::vector<sim::Hole> holes;
};

void require(bool condition, const char* message) {
  if (!condition) throw InputError(message);
}

void check(const SimulationOptions& options) {
  require(options.seconds >= 1 && options.seconds <= 36000, "--seconds: expected 1 to 36000");
  require(options.cameras == 1 || options.cameras == 2, "--cameras: expected 1 or 2");
  require(options.camera_rate_hz >= 1 && options.camera_rate_hz <= 200, "--rate-camera: expected 1 to 200 Hz");
  require(options.imu_noise.rate_hz >= 50 && options.imu_noise.rate_hz <= 4000, "--rate-imu: expected 50 to 4000 Hz");
  require(options.tracks.count >= 1 && options.tracks.count <= 2000, "--tracks: expected 1 to 2000");
  require(options.tracks.shortest >= 1 && options.tracks.shortest <= options.tracks.longest,
          "track life: expected 1 <= shortest <= longest");
  require(options.tracks.pixel_noise_px >= 0 && options.tracks.pixel_noise_px <= 20,
          "--pixel-noise: expected 0 to 20 px");
  require(options.imu_file.empty() || !options.trajectory_file.empty(),
          "--imu: expected --trajectory too, the motion that these samples belong to");
  for (const auto& effect : options.effects)
    require(options.imu_file.empty() || !effect->needs_simulated_imu(),
            "--imu: expected no effect on the IMU, real samples have their own");
}

SimulatedSession drawn_session(const SimulationOptions& options) {
  sim::Random random(options.seed, sim::Stream::clock);
  SimulatedSession session;
  session.trajectory = sim::make_trajectory(options.scenario, options.seconds, options.seed);
  session.time_zero_ns = epoch_ns + static_cast<std::int64_t>(random.uniform(0, 1e15));
  session.last_frame = options.seconds;
  return session;
}

SimulatedSession recorded_session(const SimulationOptions& options) {
  // Real IMU samples hold fast motion that the poses must follow; simulated ones only need a plausible motion.
  const double knot_step = options.imu_file.empty() ? 0.1 : 0.05;
  sim::FittedTrajectory fit = sim::fit_trajectory(options.trajectory_file, knot_step);
  SimulatedSession session;
  session.time_zero_ns = fit.first_pose_ns;
  session.first_frame = fit_margin;
  session.last_frame = std::min(fit_margin + options.seconds, fit.trajectory.last_time() - fit_margin);
  session.trajectory = std::move(fit.trajectory);
  // Across a hole the fit is a guess: a motion as good as any other for simulated samples, but wrong for real ones.
  if (!options.imu_file.empty()) session.holes = std::move(fit.holes);
  return session;
}

std::int64_t stamp(const SimulatedSession& session, double t) { return session.time_zero_ns + std::llround(t * 1e9); }

/// The time that a rounded stamp really means, so that stamps and values agree to the last digit.
double time_of(std::int64_t time_zero_ns, std::int64_t t_ns) { return static_cast<double>(t_ns - time_zero_ns) * 1e-9; }

bool in_hole(const SimulatedSession& session, double t) {
  for (const sim::Hole& hole : session.holes)
    if (t > hole.begin && t < hole.end) return true;
  return false;
}

ImuSample as_sample(std::int64_t t_ns, const sim::ImuReading& reading) {
  ImuSample sample;
  sample.t_ns = t_ns;
  for (int i = 0; i < 3; ++i) {
    sample.gyro[static_cast<std::size_t>(i)] = reading.gyro[i];
    sample.accel[static_cast<std::size_t>(i)] = reading.accel[i];
  }
  return sample;
}

TruthPose as_pose(std::int64_t t_ns, const sim::BodyState& state) {
  const Eigen::Quaterniond q(state.R_GI);
  TruthPose pose;
  pose.t_ns = t_ns;
  pose.p_GI = {state.p_GI.x(), state.p_GI.y(), state.p_GI.z()};
  pose.q_GI_wxyz = {q.w(), q.x(), q.y(), q.z()};
  return pose;
}

/// How warm the IMU is, where the recording says it. The time constant is a third of the session unless stated.
std::optional<sim::WarmUp> temperature_of(const SimulationOptions& options, const SimulatedSession& session) {
  if (options.temperature) {
    sim::WarmUp stated = *options.temperature;
    stated.begins_s = session.first_frame;
    return stated;
  }
  const bool needed =
      std::any_of(options.effects.begin(), options.effects.end(), [](const auto& e) { return e->needs_temperature(); });
  if (!needed) return std::nullopt;
  sim::WarmUp warm_up;
  warm_up.time_constant_s = (session.last_frame - session.first_frame) / 3;
  warm_up.begins_s = session.first_frame;
  return warm_up;
}

sim::NoiseFactors noise_factors(const SimulationOptions& options) {
  sim::NoiseFactors factors;
  for (const auto& effect : options.effects) effect->on_noise(factors);
  return factors;
}

/// Of tracks. Images have the exposures that their sensor chooses (render/).
std::optional<sim::AutoExposure> exposure_of(const SimulationOptions& options) {
  const bool needed =
      std::any_of(options.effects.begin(), options.effects.end(), [](const auto& e) { return e->needs_exposures(); });
  if (options.images || !(needed || options.exposures)) return std::nullopt;
  return sim::AutoExposure(options.seed);
}

/// IMU samples from a little before the first frame to a little after the last; the frames' stamps fall in between.
void simulate_imu(const SimulationOptions& options, const SimulatedSession& session, SimulationResult& result) {
  const double period = 1 / options.imu_noise.rate_hz;
  sim::Random random(options.seed + 1, sim::Stream::clock);
  const double t0 = session.first_frame - imu_lead - period * random.uniform(0.2, 0.8);
  const auto n = static_cast<std::size_t>(std::ceil((session.last_frame + imu_lead - t0) / period)) + 1;
  if (options.with_imu_noise) result.biases = sim::BiasHistory(options.seed, options.imu_noise, t0, n);
  sim::ImuWhiteNoise noise(options.seed, options.imu_noise, noise_factors(options));
  const std::optional<sim::WarmUp> warm_up = temperature_of(options, session);
  result.recording.imu.has_temperature = warm_up.has_value();
  result.warm_up = warm_up.value_or(sim::no_warm_up());
  for (std::size_t k = 0; k < n; ++k) {
    const std::int64_t t_ns = stamp(session, t0 + period * static_cast<double>(k));
    const double t = time_of(session.time_zero_ns, t_ns);
    const double temperature = result.warm_up.at(t);
    sim::ImuReading reading = sim::ideal_reading(result.truth.imu, session.trajectory, t, options.effects, temperature);
    const sim::Biases biases = result.biases.at(t);
    reading.gyro += biases.gyro;
    reading.accel += biases.accel;
    if (options.with_imu_noise) noise.add_to(reading);
    result.recording.imu.samples.push_back(as_sample(t_ns, reading));
    result.recording.imu.samples.back().temperature_degC = temperature;
  }
}

void copy_real_imu(const SimulationOptions& options, const SimulatedSession& session, SimulationResult& result) {
  result.imu_is_simulated = false;
  result.recording.imu.samples = sim::read_imu_samples(options.imu_file, stamp(session, session.first_frame - imu_lead),
                                                       stamp(session, session.last_frame + imu_lead));
}

void simulate_cameras(const SimulationOptions& options, const SimulatedSession& session, SimulationResult& result,
                      const std::function<void(double)>& progress) {
  const double period = 1 / options.camera_rate_hz;
  const auto scene = sim::make_scene(session.trajectory, session.first_frame, session.last_frame, options.seed);
  sim::TrackOptions tracks = options.tracks;
  tracks.pixel_noise_px *= noise_factors(options).pixel;
  std::vector<sim::CameraSimulator> simulators;
  for (std::size_t i = 0; i < result.truth.cameras.size(); ++i)
    simulators.emplace_back(result.truth.cameras[i], i, session.trajectory, scene, options.effects, tracks, period,
                            options.seed + seed_step_per_camera * i, result.warm_up);
  for (std::size_t i = 1; options.stereo_matches && i < simulators.size(); ++i)
    simulators[i].match_with(&simulators[0]);
  result.recording.cameras.resize(simulators.size());
  const std::optional<sim::AutoExposure> exposure = exposure_of(options);
  std::uint32_t next_track_id = 1;
  const auto frames = static_cast<int>(std::floor((session.last_frame - session.first_frame) / period + 1e-6)) + 1;
  for (int k = 0; k < frames; ++k) {
    const std::int64_t t_ns = stamp(session, session.first_frame + period * k);
    const double t = time_of(session.time_zero_ns, t_ns);
    for (std::size_t i = 0; i < simulators.size(); ++i) {
      const double exposure_s = exposure ? exposure->at(t) : 0,
                   middle = t + sim::after_stamp(options.effects, exposure_s);
      Frame frame{t_ns, options.images ? std::vector<TrackPoint>() : simulators[i].next_frame(middle, next_track_id),
                  exposure_s};
      if (!in_hole(session, t)) result.recording.cameras[i].frames.push_back(std::move(frame));
    }
    if (!in_hole(session, t)) result.frame_times.push_back(t);
    if (progress && k % 100 == 0) progress(static_cast<double>(k) / frames);
  }
}

}  // namespace

TruthState SimulationResult::state_at(std::int64_t t_ns) const {
  const double t = time_of(time_zero_ns, t_ns);
  return {trajectory.at(t), biases.at(t)};
}

SimulationResult simulate(const SimulationOptions& options, const std::function<void(double)>& progress) {
  check(options);
  const SimulatedSession session = options.trajectory_file.empty() ? drawn_session(options) : recorded_session(options);
  SimulationResult result;
  result.with_images = options.images;
  result.nominal = sim::nominal_device(options.distortion, options.cameras);
  for (CameraCalibration& camera : result.nominal.cameras) camera.reads_columns = options.reads_columns;
  result.device_seed = options.device_seed.value_or(options.seed);
  result.truth = sim::draw_device(result.nominal, result.device_seed, options.device_scale);
  if (options.change_device) options.change_device(result.truth);
  result.recording.imu.noise = options.imu_noise;
  options.imu_file.empty() ? simulate_imu(options, session, result) : copy_real_imu(options, session, result);
  simulate_cameras(options, session, result, progress);
  for (const ImuSample& sample : result.recording.imu.samples) {
    const double t = time_of(session.time_zero_ns, sample.t_ns);
    if (!in_hole(session, t)) result.recording.truth.push_back(as_pose(sample.t_ns, session.trajectory.at(t)));
  }
  for (const auto& effect : options.effects) {
    effect->on_log(result.recording, options.seed);
    result.effects.push_back(effect->truth());
  }
  result.trajectory = session.trajectory;
  result.time_zero_ns = session.time_zero_ns;
  return result;
}

}  // namespace host
