#include "simulate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "device.h"
#include "exposures.h"
#include "real_imu.h"
#include "scene.h"
#include "session.h"

namespace host {
namespace {

constexpr double imu_lead = 0.05;  // s of IMU samples before the first frame and after the last
constexpr std::uint64_t seed_step_per_camera = 1000003;

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
std::optional<sim::WarmUp> temperature_of(const SimulationOptions& options, const sim::Session& session) {
  if (options.replica && !options.replica->temperatures_degC.empty()) {
    sim::WarmUp recorded;
    recorded.measured = options.replica->temperatures_degC;
    return recorded;
  }
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

/// Of tracks: the exposure of the image stamped t. Images have those that their sensor chooses (render/).
std::function<double(double)> exposure_of(const SimulationOptions& options) {
  if (options.replica && !options.replica->exposures_s.empty())
    return [&options](double t) { return sim::latest(options.replica->exposures_s, t); };
  const bool needed =
      std::any_of(options.effects.begin(), options.effects.end(), [](const auto& e) { return e->needs_exposures(); });
  if (options.images || !(needed || options.exposures)) return {};
  return [exposure = sim::AutoExposure(options.seed)](double t) { return exposure.at(t); };
}

/// IMU samples from a little before the first frame to a little after the last; the frames' stamps fall in between.
void simulate_imu(const SimulationOptions& options, const sim::Session& session, SimulationResult& result) {
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
    const std::int64_t t_ns = session.stamp(t0 + period * static_cast<double>(k));
    const double t = session.time_of(t_ns);
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

void copy_real_imu(const SimulationOptions& options, const sim::Session& session, SimulationResult& result) {
  result.imu_is_simulated = false;
  result.recording.imu.samples = sim::read_imu_samples(options.imu_file, session.stamp(session.first_frame - imu_lead),
                                                       session.stamp(session.last_frame + imu_lead));
}

void simulate_cameras(const SimulationOptions& options, const sim::Session& session, SimulationResult& result,
                      const std::function<void(double)>& progress) {
  const double period = 1 / options.camera_rate_hz;
  const auto scene = options.replica
                         ? options.replica->landmarks_G
                         : sim::make_scene(session.trajectory, session.first_frame, session.last_frame, options.seed);
  sim::TrackOptions tracks = options.tracks;
  tracks.pixel_noise_px *= noise_factors(options).pixel;
  std::vector<sim::CameraSimulator> simulators;
  for (std::size_t i = 0; i < result.truth.cameras.size(); ++i)
    simulators.emplace_back(result.truth.cameras[i], i, session.trajectory, scene, options.effects, tracks, period,
                            options.seed + seed_step_per_camera * i, result.warm_up);
  for (std::size_t i = 1; options.stereo_matches && i < simulators.size(); ++i)
    simulators[i].match_with(&simulators[0]);
  result.recording.cameras.resize(simulators.size());
  const std::function<double(double)> exposure = exposure_of(options);
  std::uint32_t next_track_id = 1;
  const auto frames = static_cast<int>(std::floor((session.last_frame - session.first_frame) / period + 1e-6)) + 1;
  for (int k = 0; k < frames; ++k) {
    const std::int64_t t_ns = session.stamp(session.first_frame + period * k);
    const double t = session.time_of(t_ns);
    for (std::size_t i = 0; i < simulators.size(); ++i) {
      const double exposure_s = exposure ? exposure(t) : 0, middle = t + sim::after_stamp(options.effects, exposure_s);
      Frame frame{t_ns, options.images ? std::vector<TrackPoint>() : simulators[i].next_frame(middle, next_track_id),
                  exposure_s};
      if (!session.in_hole(t)) result.recording.cameras[i].frames.push_back(std::move(frame));
    }
    if (!session.in_hole(t)) result.frame_times.push_back(t);
    if (progress && k % 100 == 0) progress(static_cast<double>(k) / frames);
  }
}

}  // namespace

TruthState SimulationResult::state_at(std::int64_t t_ns) const {
  const double t = static_cast<double>(t_ns - time_zero_ns) * 1e-9;
  return {trajectory.at(t), biases.at(t)};
}

SimulationResult simulate(const SimulationOptions& options, const std::function<void(double)>& progress) {
  check(options);
  const sim::Session session = sim::session_of(options);
  SimulationResult result;
  result.with_images = options.images;
  result.nominal = sim::nominal_device(options.distortion, options.cameras);
  for (CameraCalibration& camera : result.nominal.cameras) camera.reads_columns = options.reads_columns;
  result.device_seed = options.device_seed.value_or(options.seed);
  result.truth = sim::draw_device(result.nominal, result.device_seed, options.device_scale);
  if (options.replica) {
    result.nominal = options.replica->start;
    result.truth = options.replica->device;
  }
  if (options.change_device) options.change_device(result.truth);
  result.recording.imu.noise = options.imu_noise;
  options.imu_file.empty() ? simulate_imu(options, session, result) : copy_real_imu(options, session, result);
  simulate_cameras(options, session, result, progress);
  for (const ImuSample& sample : result.recording.imu.samples) {
    const double t = session.time_of(sample.t_ns);
    if (!session.in_hole(t)) result.recording.truth.push_back(as_pose(sample.t_ns, session.trajectory.at(t)));
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
