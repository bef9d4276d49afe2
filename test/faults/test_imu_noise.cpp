// Noise of the raw samples: the stated one is found as stated whatever the motion, a wrong one by its factor.
#include <cmath>

#include "../support/cases.h"
#include "diagnose/imu_noise.h"
#include "simulate/effect_names.h"
#include "simulate/random.h"
#include "simulate/simulate.h"
#include "unity.h"

using Verdict = host::SensorNoise::Verdict;

namespace {

host::RawNoise noise_of(const std::string& scenario, std::uint64_t seed, const std::string& effect = "",
                        double seconds = 60) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = seconds;
  options.seed = seed;
  options.tracks.count = 8;  // only the span of the frames matters
  if (!effect.empty()) options.effects.push_back(host::sim::parse_effect(effect));
  return host::raw_imu_noise(host::simulate(options).recording);
}

/// The factor within four of its own sigmas, and the sigma as small as sixty seconds allow.
void check_factor(const test::Id& id, const host::SensorNoise& noise, double expected, Verdict verdict) {
  if (!test::selected(id.text())) return;
  test::check_near(id, "factor", expected, noise.factor, 4 * noise.sigma);
  test::check_between(id, "relative sigma", 0.005, noise.sigma / noise.factor, 0.06);
  test::check_true(id, noise.words.c_str(), noise.verdict == verdict);
}

void stated_noise_is_found_under_any_motion() {
  for (const char* scenario : {"rich", "arvr", "nav", "still", "rotation", "line", "planar"})
    for (std::uint64_t seed : {1, 2, 3, 4}) {
      const auto id = test::Id().add("scenario", scenario).add("seed", seed);
      const auto noise = noise_of(scenario, seed);
      check_factor(id.add("sensor", "gyro"), noise.gyro, 1, Verdict::as_stated);
      check_factor(id.add("sensor", "accel"), noise.accel, 1, Verdict::as_stated);
    }
}

void a_wrong_factor_is_found_on_its_sensor_alone() {
  for (const char* scenario : {"rich", "nav", "still"}) {
    const auto id = test::Id().add("scenario", scenario);
    auto noise = noise_of(scenario, 5, "imu_noise=3,1");
    check_factor(id.add("case", "gyro3"), noise.gyro, 3, Verdict::above);
    check_factor(id.add("case", "accel1"), noise.accel, 1, Verdict::as_stated);
    noise = noise_of(scenario, 6, "imu_noise=1,2");
    check_factor(id.add("case", "gyro1"), noise.gyro, 1, Verdict::as_stated);
    check_factor(id.add("case", "accel2"), noise.accel, 2, Verdict::above);
    noise = noise_of(scenario, 7, "imu_noise=0.2");
    check_factor(id.add("case", "gyro0.2"), noise.gyro, 0.2, Verdict::below);
  }
}

/// Over many seeds (error / sigma)^2 has the mean 1; 60 values of it scatter by 0.18.
void the_stated_uncertainty_is_honest() {
  double squares = 0;
  int n = 0;
  for (std::uint64_t seed = 100; seed < 130; ++seed) {
    const auto noise = noise_of("rich", seed, "", 30);
    for (const auto* s : {&noise.gyro, &noise.accel}) {
      squares += std::pow((s->factor - 1) / s->sigma, 2);
      ++n;
    }
  }
  test::check_between(test::Id().add("check", "mean of squares"), "mean", 0.5, squares / n, 1.6);
}

void allan_deviation_at_rest_agrees() {
  const auto noise = noise_of("still", 8);
  TEST_ASSERT_TRUE(noise.rest_s > 55);
  for (const auto* s : {&noise.gyro, &noise.accel}) {
    TEST_ASSERT_TRUE(s->allan.size() > 5);
    // 0.1 to 0.5 s within 60 s: 120 blocks and more, 6 % of the deviation.
    for (const auto& axis : s->axes) TEST_ASSERT_DOUBLE_WITHIN(0.2 * s->stated, s->stated, axis.allan_density);
  }
  TEST_ASSERT_TRUE(noise_of("rich", 8).gyro.allan.empty());
}

/// Strong for a third of the time, weaker for another, off for none: more than noise, and not steady.
void vibration_that_comes_and_goes_is_not_called_noise() {
  host::SimulationOptions options;
  options.seed = 9;
  options.tracks.count = 8;
  auto recording = host::simulate(options).recording;
  host::sim::Random random(3, host::sim::Stream::motion);
  const double first = static_cast<double>(recording.imu.samples.front().t_ns);
  for (auto& s : recording.imu.samples) {
    const double t = (static_cast<double>(s.t_ns) - first) * 1e-9, size = 0.3 * (1.2 + std::sin(0.9 * t));
    for (double& f : s.accel) f += size * random.normal();
  }
  const auto noise = host::raw_imu_noise(recording);
  TEST_ASSERT_FALSE(noise.accel.steady);
  TEST_ASSERT_TRUE(noise.accel.verdict == Verdict::cannot_tell);
  TEST_ASSERT_TRUE(noise.gyro.verdict == Verdict::as_stated);
}

/// White, and larger where it moves: said so, by about its size. A motion alone, however quick, is not called that, nor
/// is a noise that is the same throughout.
void noise_that_grows_with_motion_is_told() {
  for (std::uint64_t seed : {11, 12, 13}) {
    const auto id = test::Id().add("seed", seed);
    for (const char* effect : {"", "imu_noise=3"}) {
      for (const char* scenario : {"rich", "arvr", "nav"}) {
        const auto sound = noise_of(scenario, seed, effect);
        test::check_true(id, sound.gyro.words.c_str(), !sound.gyro.grows);
        test::check_true(id, sound.accel.words.c_str(), !sound.accel.grows);
      }
    }
    const auto noise = noise_of("rich", seed, "outside:noise_with_motion=0,4");
    test::check_true(id, noise.accel.words.c_str(), noise.accel.grows);
    test::check_true(id, noise.gyro.words.c_str(), !noise.gyro.grows);
    // rates of 1 to 5 rad/s in the lively quarter: sqrt(1 + (4 w)^2)
    test::check_between(id, "lively factor", 4, noise.accel.lively_factor, 20);
  }
}

void too_little_says_so() {
  const auto noise = noise_of("rich", 10, "", 1);
  TEST_ASSERT_TRUE(noise.gyro.verdict == Verdict::cannot_tell);
  TEST_ASSERT_FALSE(noise.gyro.words.empty());
  TEST_ASSERT_TRUE(host::raw_imu_noise({}).gyro.verdict == Verdict::cannot_tell);
}

}  // namespace

void setUp() {}
void tearDown() {}

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(stated_noise_is_found_under_any_motion);
  RUN_TEST(a_wrong_factor_is_found_on_its_sensor_alone);
  RUN_TEST(the_stated_uncertainty_is_honest);
  RUN_TEST(allan_deviation_at_rest_agrees);
  RUN_TEST(vibration_that_comes_and_goes_is_not_called_noise);
  RUN_TEST(noise_that_grows_with_motion_is_told);
  RUN_TEST(too_little_says_so);
  return UNITY_END();
}
