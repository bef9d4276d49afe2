// The temperature column: readings that jump away and back are
// found; coarse, noisy and slow columns are as they should be.
#include <unity.h>

#include <cmath>
#include <limits>
#include <random>

#include "diagnose/fault.h"
#include "imu_temperature.h"
#include "replay/replay.h"
#include "segcal/segcal.h"
#include "simulate/simulate.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using host::ImuData;

constexpr double rate_hz = 200;

/// A minute of warming up, from 25 towards 40 degC.
ImuData warming_up() {
  ImuData imu;
  imu.has_temperature = true;
  for (int i = 0; i < 60 * 200; ++i) {
    host::ImuSample sample;
    sample.t_ns = 5'000'000LL * i;
    sample.temperature_degC = 40 - 15 * std::exp(-i / rate_hz / 20);
    imu.samples.push_back(sample);
  }
  return imu;
}

template <class Change>
ImuData changed(const Change& change) {
  ImuData imu = warming_up();
  std::mt19937 random(7);
  for (std::size_t i = 0; i < imu.samples.size(); ++i) change(imu.samples[i].temperature_degC, i, random);
  return imu;
}

bool with_share(std::mt19937& random, double share) { return std::uniform_real_distribution<>()(random) < share; }

void check_sound(const char* name, const ImuData& before) {
  ImuData imu = before;
  host::check_temperature(&imu, true);
  TEST_ASSERT_EQUAL_size_t_MESSAGE(0, imu.temperature_jumps.count, name);
  TEST_ASSERT_TRUE_MESSAGE(imu.has_temperature, name);
}

void test_columns_that_are_as_they_should_be() {
  const auto rounded = [](double step) {
    return changed([step](double& t, std::size_t, std::mt19937&) { t = step * std::round(t / step); });
  };
  const auto held = [](double hz, double offset) {
    const ImuData truth = warming_up();
    const auto n = static_cast<std::size_t>(rate_hz / hz);
    return changed(
        [&](double& t, std::size_t i, std::mt19937&) { t = truth.samples[i / n * n].temperature_degC + offset; });
  };
  const auto noisy = [](double sigma, double step) {
    return changed([=](double& t, std::size_t, std::mt19937& random) {
      t = step * std::round((t + std::normal_distribution<>(0, sigma)(random)) / step);
    });
  };
  check_sound("as it is", warming_up());
  check_sound("steps of 0.5 K", rounded(0.5));
  check_sound("steps of 1 K", rounded(1));
  check_sound("steps of 1 K that flicker", noisy(0.4, 1));
  check_sound("noise of 0.5 K", noisy(0.5, 0.01));
  check_sound("1 Hz", held(1, 0));
  check_sound("0.2 Hz", held(0.2, 0));  // 3.3 K a step at the start
  check_sound("1 Hz, about 0 degC", held(1, -30));
  check_sound("0 degC throughout", changed([](double& t, std::size_t, std::mt19937&) { t = 0; }));
  check_sound("a number now and then", changed([](double& t, std::size_t i, std::mt19937&) {
                t = i % 200 ? std::numeric_limits<double>::quiet_NaN() : t;
              }));
}

/// What is left after the mending is within two kelvins of the truth.
void check_bridged(const char* name, ImuData imu, std::size_t least) {
  const ImuData truth = warming_up();
  host::check_temperature(&imu, true);
  TEST_ASSERT_TRUE_MESSAGE(imu.has_temperature && imu.temperature_jumps.bridged, name);
  TEST_ASSERT_GREATER_OR_EQUAL_size_t_MESSAGE(least, imu.temperature_jumps.count, name);
  TEST_ASSERT_TRUE_MESSAGE(host::temperature_words(imu).find("held in their place") != std::string::npos, name);
  double worst = 0;
  for (std::size_t i = 0; i < imu.samples.size(); ++i)
    worst = std::max(worst, std::abs(imu.samples[i].temperature_degC - truth.samples[i].temperature_degC));
  TEST_ASSERT_TRUE_MESSAGE(worst < 2.1,
                           name);  // below 2 K it may be a coarse column; a bridge of 2 s at 0.75 K/s is 1.5
}

void test_few_jumps_are_bridged() {
  const auto spikes = [](double share, double value) {
    return changed([=](double& t, std::size_t, std::mt19937& random) {
      if (with_share(random, share)) t = value;
    });
  };
  check_bridged("1 % of -41 degC", spikes(0.01, -41), 80);
  check_bridged("4 % of 0 degC", spikes(0.04, 0), 400);
  check_bridged("1 % of 35 degC", spikes(0.01, 35), 15);
  check_bridged("1 % anywhere", changed([](double& t, std::size_t, std::mt19937& random) {
                  if (with_share(random, 0.01)) t = std::uniform_real_distribution<>(-40, 85)(random);
                }),
                80);
  check_bridged("the first", changed([](double& t, std::size_t i, std::mt19937&) {
                  if (i < 3) t = 0;
                }),
                3);
  check_bridged("2 s in a row", changed([](double& t, std::size_t i, std::mt19937&) {
                  if (i >= 5000 && i < 5400) t = -41;
                }),
                400);
  check_bridged("1 % of a column held for 1 s", changed([](double& t, std::size_t i, std::mt19937& random) {
                  t = with_share(random, 0.01) ? -41 : 40 - 15 * std::exp(-static_cast<double>(i / 200) / 20);
                }),
                80);
}

void check_refused(const char* name, ImuData imu) {
  host::check_temperature(&imu, true);
  TEST_ASSERT_FALSE_MESSAGE(imu.has_temperature, name);
  TEST_ASSERT_TRUE_MESSAGE(host::temperature_words(imu).find("cannot be estimated") != std::string::npos, name);
}

void test_many_jumps_are_refused() {
  for (const double share : {0.1, 0.5, 0.9, 0.97})
    check_refused("zeros between readings", changed([share](double& t, std::size_t, std::mt19937& random) {
                    if (with_share(random, share)) t = 0;
                  }));
  check_refused("a reading a second, else zero", changed([](double& t, std::size_t i, std::mt19937&) {
                  if (i % 200) t = 0;
                }));
  check_refused("a reading a second, else -41", changed([](double& t, std::size_t i, std::mt19937&) {
                  if (i % 200) t = -41;
                }));
  check_refused("another level from the middle on", changed([](double& t, std::size_t i, std::mt19937&) {
                  if (i > 7000) t -= 60;
                }));
  check_refused("every other one", changed([](double& t, std::size_t i, std::mt19937&) {
                  if (i % 2) t = -41;
                }));
}

/// Zeros between readings, an effect that follows them: no calibration, and the sentence names the temperature.
void test_a_replay_takes_back_what_followed_them() {
  host::SimulationOptions options;
  options.seconds = 20;
  const host::SimulationResult simulated = host::simulate(options);
  host::Recording recording = simulated.recording;
  recording.imu.has_temperature = true;
  for (std::size_t i = 0; i < recording.imu.samples.size(); ++i)
    recording.imu.samples[i].temperature_degC = i % 10 ? 0 : 30 + 1e-3 * static_cast<double>(i);
  host::check_temperature(&recording.imu, true);
  host::ReplayOptions replaying;
  replaying.core.calibration = simulated.nominal;
  replaying.core.noise = recording.imu.noise;
  replaying.review = true;
  TEST_ASSERT_EQUAL_STRING("calibrated",
                           replay({recording}, replaying).result.status.c_str());  // nobody asked for the temperature
  replaying.core.effects = SEGCAL_EFFECT_GYRO_TEMPERATURE;
  const host::ReplayResult result = replay({recording}, replaying);
  TEST_ASSERT_EQUAL_STRING("insufficient", result.result.status.c_str());
  TEST_ASSERT_EQUAL_size_t(0, result.cause.find("temperature: "));
  TEST_ASSERT_EQUAL_STRING("temperature_spikes.imu", result.health.suspects.back().name.c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_columns_that_are_as_they_should_be);
  RUN_TEST(test_few_jumps_are_bridged);
  RUN_TEST(test_many_jumps_are_refused);
  RUN_TEST(test_a_replay_takes_back_what_followed_them);
  return UNITY_END();
}
