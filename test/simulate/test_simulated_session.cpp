// A simulated session as a whole: tracks, statistics of noise and devices, repeatability, effects, bad options.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "simulate/device.h"
#include "simulate/scenarios.h"
#include "simulate/simulate.h"
#include "unity.h"

namespace {

host::SimulationOptions session(const std::string& scenario, double seconds = 30) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = seconds;
  return options;
}

void tracks_keep_their_number_and_life_span() {
  for (const char* scenario : {"arvr", "nav", "rich"}) {
    const auto result = host::simulate(session(scenario));
    const auto& frames = result.recording.cameras[0].frames;
    TEST_ASSERT_EQUAL_size_t(301, frames.size());
    std::map<std::uint32_t, std::size_t> first, last, count;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      TEST_ASSERT_TRUE_MESSAGE(frames[k].points.size() >= 40 && frames[k].points.size() <= 60, scenario);
      for (const auto& point : frames[k].points) {
        first.emplace(point.track_id, k);
        last[point.track_id] = k;
        ++count[point.track_id];
      }
    }
    for (const auto& [id, n] : count) {
      TEST_ASSERT_EQUAL_size_t_MESSAGE(last[id] - first[id] + 1, n, "a track has no gaps");
      TEST_ASSERT_TRUE_MESSAGE(n <= 45, "a track lives 45 frames at most");
      TEST_ASSERT_TRUE_MESSAGE(n >= 6 || last[id] + 1 == frames.size(), "a track lives 6 frames at least");
    }
  }
}

void tracks_reach_every_part_of_the_image() {
  const auto result = host::simulate(session("rich", 60));
  std::array<int, 16> cells{};
  for (const auto& frame : result.recording.cameras[0].frames)
    for (const auto& point : frame.points)
      ++cells[static_cast<std::size_t>(point.u / 160) + 4 * static_cast<std::size_t>(point.v / 120)];
  for (int count : cells) TEST_ASSERT_TRUE_MESSAGE(count > 300, "each sixteenth of the image, corners too");
}

void pixel_noise_has_the_stated_deviation() {
  host::SimulationOptions options = session("arvr");
  const auto noisy = host::simulate(options);
  options.tracks.pixel_noise_px = 0;
  const auto exact = host::simulate(options);
  double sum = 0, n = 0;
  for (std::size_t k = 0; k < exact.recording.cameras[0].frames.size(); ++k) {
    const auto& exact_points = exact.recording.cameras[0].frames[k].points;
    const auto& noisy_points = noisy.recording.cameras[0].frames[k].points;
    TEST_ASSERT_EQUAL_size_t(exact_points.size(), noisy_points.size());
    for (std::size_t i = 0; i < exact_points.size(); ++i) {
      TEST_ASSERT_EQUAL_UINT32(exact_points[i].track_id, noisy_points[i].track_id);
      sum += std::pow(exact_points[i].u - noisy_points[i].u, 2) + std::pow(exact_points[i].v - noisy_points[i].v, 2);
      n += 2;
    }
  }
  TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.5, std::sqrt(sum / n));
}

void imu_noise_has_the_stated_density() {
  host::SimulationOptions options = session("still", 60);
  options.device_scale = 0;
  const auto result = host::simulate(options);
  double gyro = 0, accel = 0, n = 0;
  for (const auto& sample : result.recording.imu.samples) {
    const auto truth = result.state_at(sample.t_ns);
    const Eigen::Vector3d f_I = truth.body.R_GI.transpose() * Eigen::Vector3d(0, 0, 9.80665);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      gyro += std::pow(sample.gyro[i] - truth.biases.gyro[axis], 2);
      accel += std::pow(sample.accel[i] - f_I[axis] - truth.biases.accel[axis], 2);
      ++n;
    }
  }
  TEST_ASSERT_DOUBLE_WITHIN(0.02, 1, std::sqrt(gyro / n) / (1.7e-4 * std::sqrt(200.0)));
  TEST_ASSERT_DOUBLE_WITHIN(0.02, 1, std::sqrt(accel / n) / (2e-3 * std::sqrt(200.0)));
}

void devices_scatter_as_stated() {
  const auto nominal = host::sim::nominal_device(host::DistortionModel::fov, 1);
  const auto reference = host::sim::named_parameters(nominal, true);
  TEST_ASSERT_EQUAL_size_t(26, reference.size());
  const std::map<std::string, double> sigmas = {{"cam0.fx", 1},         {"cam0.cy", 1},      {"cam0.w", 0.005},
                                                {"cam0.p_CI.y", 0.004}, {"gyro.sx", 0.004},  {"gyro.mz", 0.002},
                                                {"accel.sy", 0.012},    {"accel.mx", 0.012}, {"accel.r_AI.x", 0.012}};
  std::map<std::string, double> sum;
  const int devices = 2000;
  for (int seed = 0; seed < devices; ++seed) {
    const auto device = host::sim::draw_device(nominal, static_cast<std::uint64_t>(seed), 1);
    const auto values = host::sim::named_parameters(device, true);
    for (std::size_t i = 0; i < values.size(); ++i)
      sum[values[i].name] += std::pow(values[i].value - reference[i].value, 2) / devices;
  }
  for (const auto& [name, sigma] : sigmas)
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.08, 1, std::sqrt(sum[name]) / sigma, name.c_str());
}

void the_same_seed_gives_the_same_session_and_device_seed_the_device() {
  host::SimulationOptions options = session("nav", 10);
  const auto first = host::simulate(options), again = host::simulate(options);
  TEST_ASSERT_EQUAL_MEMORY(first.recording.imu.samples[500].gyro.data(), again.recording.imu.samples[500].gyro.data(),
                           24);
  TEST_ASSERT_EQUAL_UINT32(first.recording.cameras[0].frames.back().points.back().track_id,
                           again.recording.cameras[0].frames.back().points.back().track_id);
  options.device_seed = options.seed;
  options.seed = 2;
  const auto other = host::simulate(options);
  TEST_ASSERT_TRUE(first.truth.imu.T_g == other.truth.imu.T_g);
  TEST_ASSERT_TRUE(first.recording.imu.samples[0].t_ns != other.recording.imu.samples[0].t_ns);
}

void stamps_enclose_the_frames_and_do_not_coincide_with_them() {
  const auto result = host::simulate(session("arvr", 10));
  const auto& samples = result.recording.imu.samples;
  const auto& frames = result.recording.cameras[0].frames;
  TEST_ASSERT_TRUE(samples.front().t_ns <= frames.front().t_ns - 50000000);
  TEST_ASSERT_TRUE(samples.back().t_ns >= frames.back().t_ns + 50000000);
  std::set<std::int64_t> stamps;
  for (const auto& sample : samples) stamps.insert(sample.t_ns);
  for (const auto& frame : frames) TEST_ASSERT_EQUAL_size_t(0, stamps.count(frame.t_ns));
}

void scenarios_move_as_the_paper_describes() {
  const std::map<std::string, std::array<double, 4>> ranges = {// m/s from, to; deg/s from, to
                                                               {"arvr", {0.15, 0.40, 18, 38}},
                                                               {"nav", {0.45, 0.72, 13, 28}}};
  for (const auto& [name, range] : ranges) {
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      const auto trajectory = host::sim::make_trajectory(name, 120, seed);
      double speed = 0, rate = 0;
      for (int k = 0; k < 1200; ++k) {
        speed += trajectory.at(0.1 * k).v_GI.norm() / 1200;
        rate += trajectory.at(0.1 * k).w_GI.norm() / 1200 * 57.29578;
      }
      TEST_ASSERT_TRUE_MESSAGE(speed > range[0] && speed < range[1], name.c_str());
      TEST_ASSERT_TRUE_MESSAGE(rate > range[2] && rate < range[3], name.c_str());
    }
  }
}

/// Mean rate of rotation in each stretch of 4 s, deg/s, and the share of time at rest.
struct Rotation {
  std::vector<double> by_stretch;
  double rest = 0;
};

Rotation rotation_of(const std::string& scenario, std::uint64_t seed) {
  const auto trajectory = host::sim::make_trajectory(scenario, 120, seed);
  Rotation out;
  out.by_stretch.resize(30);
  for (std::size_t k = 0; k < 2400; ++k) {
    const auto state = trajectory.at(0.05 * static_cast<double>(k));
    const double rate = state.w_GI.norm() * 57.29578;
    out.by_stretch[k / 80] += rate / 80;
    out.rest += state.v_GI.norm() < 0.02 && rate < 2 ? 1.0 / 2400 : 0;
  }
  std::sort(out.by_stretch.begin(), out.by_stretch.end());
  return out;
}

/// "Mostly fast rotations ... and stationary phases" against "only slow rotations", at nearly the same mean rate.
void arvr_turns_in_bursts_and_rests_between() {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Rotation arvr = rotation_of("arvr", seed), nav = rotation_of("nav", seed);
    const std::string id = "seed " + std::to_string(seed);
    TEST_ASSERT_TRUE_MESSAGE(arvr.rest > 0.1 && arvr.rest < 0.4, id.c_str());
    // One stretch in ten is turned through at more than twice the mean, which nav never does.
    TEST_ASSERT_TRUE_MESSAGE(arvr.by_stretch[27] > 40, id.c_str());
    TEST_ASSERT_TRUE_MESSAGE(nav.by_stretch[27] < 40, id.c_str());
    TEST_ASSERT_TRUE_MESSAGE(arvr.by_stretch[3] < 8, id.c_str());
  }
}

struct LateCamera : host::sim::Effect {
  double exposure_time(const host::CameraCalibration&, double t_stamp, double) const override { return t_stamp + 0.02; }
};

void an_effect_reaches_the_tracks() {
  host::SimulationOptions options = session("rich", 3);
  options.tracks.pixel_noise_px = 0;
  const auto on_time = host::simulate(options);
  options.effects.push_back(std::make_shared<LateCamera>());
  const auto late = host::simulate(options);
  const auto& a = on_time.recording.cameras[0].frames[0].points;
  const auto& b = late.recording.cameras[0].frames[0].points;
  TEST_ASSERT_TRUE(std::abs(a[0].u - b[0].u) + std::abs(a[0].v - b[0].v) > 0.1);
  TEST_ASSERT_EQUAL_MEMORY(on_time.recording.imu.samples[9].accel.data(), late.recording.imu.samples[9].accel.data(),
                           24);
}

bool refused(const std::function<void(host::SimulationOptions&)>& spoil) {
  host::SimulationOptions options = session("rich", 5);
  spoil(options);
  try {
    host::simulate(options);
  } catch (const host::InputError&) {
    return true;
  }
  return false;
}

void bad_options_are_refused() {
  TEST_ASSERT_TRUE(refused([](auto& o) { o.scenario = "swim"; }));
  TEST_ASSERT_TRUE(refused([](auto& o) { o.seconds = 0; }));
  TEST_ASSERT_TRUE(refused([](auto& o) { o.seconds = std::nan(""); }));
  TEST_ASSERT_TRUE(refused([](auto& o) { o.cameras = 3; }));
  TEST_ASSERT_TRUE(refused([](auto& o) { o.tracks.count = 0; }));
  TEST_ASSERT_TRUE(refused([](auto& o) { o.imu_noise.rate_hz = 0; }));
  TEST_ASSERT_TRUE(refused([](auto& o) { o.imu_file = "imu.csv"; }));
  TEST_ASSERT_TRUE(refused([](auto& o) { o.trajectory_file = "no_such_file.csv"; }));
}

}  // namespace

void setUp() {}
void tearDown() {}

int main() {
  UNITY_BEGIN();
  RUN_TEST(tracks_keep_their_number_and_life_span);
  RUN_TEST(tracks_reach_every_part_of_the_image);
  RUN_TEST(pixel_noise_has_the_stated_deviation);
  RUN_TEST(imu_noise_has_the_stated_density);
  RUN_TEST(devices_scatter_as_stated);
  RUN_TEST(the_same_seed_gives_the_same_session_and_device_seed_the_device);
  RUN_TEST(stamps_enclose_the_frames_and_do_not_coincide_with_them);
  RUN_TEST(scenarios_move_as_the_paper_describes);
  RUN_TEST(arvr_turns_in_bursts_and_rests_between);
  RUN_TEST(an_effect_reaches_the_tracks);
  RUN_TEST(bad_options_are_refused);
  return UNITY_END();
}
