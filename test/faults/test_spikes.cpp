// Readings that no motion explains, one or two in a row: each is found,
// and no reading of a motion is taken for one, however suddenly it begins.
#include <algorithm>
#include <cmath>
#include <vector>

#include "../support/cases.h"
#include "../support/random.h"
#include "diagnose/fault.h"
#include "unity.h"

using host::ImuSample;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr double kGyroNoise = 2.4e-3, kAccelNoise = 0.028;  // of one reading at 200 Hz and the default densities
constexpr std::size_t kReadings = 2000;                     // 10 s

using Stream = std::vector<ImuSample>;

/// Turns and swings of 1 to 2 Hz, with white noise.
Stream motion(std::uint64_t seed, double size) {
  test::Random random(seed);
  Stream out(kReadings);
  for (std::size_t i = 0; i < kReadings; ++i) {
    const double t = double(i) / 200;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<double>(k);
      out[i].gyro[k] = size * 2 * std::sin(2 * M_PI * (1 + 0.3 * axis) * t) + kGyroNoise * random.normal();
      out[i].accel[k] =
          (k == 2 ? 9.8 : 0) + size * 5 * std::cos(2 * M_PI * (1.2 + 0.3 * axis) * t) + kAccelNoise * random.normal();
    }
  }
  return out;
}

host::Recording recording_of(Stream stream, double rate_hz) {
  host::Recording recording;
  for (std::size_t i = 0; i < stream.size(); ++i) stream[i].t_ns = std::int64_t(double(i) * 1e9 / rate_hz);
  recording.imu.samples = std::move(stream);
  recording.imu.noise.rate_hz = rate_hz;
  return recording;
}

std::vector<std::size_t> spikes_in(Stream stream, double rate_hz = 200) {
  return host::spikes_of(recording_of(std::move(stream), rate_hz));
}

void check(const Id& id, const Stream& stream, const std::vector<std::size_t>& spikes) {
  test::check_true(id, "the spikes that were put in, and no others", spikes_in(stream) == spikes);
}

template <class Run>
void each_seed(std::uint64_t count, const Run& run) {
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    const Id id = Id().add("seed", seed);
    if (test::selected(id.text())) run(id, seed);
  }
}

/// From 0.35 rad/s and 1.6 m/s^2 to just below full scale; either sensor, any axis; every other one is twice as large
/// at least and goes on for a second reading, alike or of the other sign. At full scale the device leaves them out
/// itself, and of a slow sensor one reading, or two, may be a twitch.
void test_spikes_are_found() {
  each_seed(20, [](const Id& id, std::uint64_t seed) {
    test::Random random(seed + 100);
    Stream stream = motion(seed, seed % 2 ? 1 : 0.1);
    std::vector<std::size_t> spikes;
    for (std::size_t at = 100; at < kReadings - 100; at += 50) {
      const int axis = random.index(6);
      const double share = std::pow(10.0, -random.uniform(0.15, at % 100 ? 2 : 1.7)),
                   sign = random.uniform(0, 1) < 0.5 ? -1 : 1;  // of full scale: 0.01 or 0.02 to 0.7
      const double size = sign * share * (axis < 3 ? 35 : 157), second = at % 100 ? 0
                                                                         : random.uniform(0, 1) < 0.2
                                                                             ? -size
                                                                             : size * random.uniform(0.8, 1.2);
      const auto value = [&](std::size_t i) -> double& {
        return axis < 3 ? stream[i].gyro[std::size_t(axis)] : stream[i].accel[std::size_t(axis - 3)];
      };
      value(at) += size;
      spikes.push_back(at);
      if (second == 0) continue;
      value(at + 1) += second;
      spikes.push_back(at + 1);
    }
    stream[1925].accel[0] = 160;
    check(id, stream, spikes);
    test::check_true(id, "none at 50 Hz", spikes_in(stream, 50).empty());
    const std::vector<std::size_t> slower = spikes_in(stream, 120);
    const auto even = [](std::size_t at) { return at % 100 == 50; };
    test::check_true(id, "one alone at 120 Hz", std::count_if(slower.begin(), slower.end(), even) == 18);
    test::check_true(id, "no pair at 120 Hz",
                     std::none_of(slower.begin(), slower.end(), [](std::size_t at) { return at % 100 == 1; }));
  });
}

/// A shock to the die: one sensor's reading alone, while the other rings and fades.
void test_a_spike_takes_no_sound_reading_with_it() {
  each_seed(20, [](const Id& id, std::uint64_t seed) {
    Stream stream = motion(seed, 0);
    double ring = (0.06 + 0.003 * double(seed));
    for (std::size_t i = 500; i < 506; ++i, ring *= 0.55) stream[i].gyro[0] += ring;
    stream[500].accel[1] += 30;
    check(id, stream, {500});
  });
}

/// A knock that goes on, with a spike soon after it; one that
/// rings; a jump to another rate; readings that repeat; some lost.
void test_motion_is_no_spike() {
  each_seed(20, [](const Id& id, std::uint64_t seed) {
    Stream stream = motion(seed, 1);
    for (std::size_t i = 500; i < 503; ++i) stream[i].accel[1] += 60;
    stream[520].accel[2] += 4;
    for (std::size_t i = 900; i < 905; ++i) stream[i].accel[0] += i % 2 ? -40 : 40;
    for (std::size_t i = 1200; i < kReadings; ++i) stream[i].gyro[2] += 8;
    for (std::size_t i = 1500; i < 1700; ++i) stream[i] = stream[1500];
    stream.erase(stream.begin() + 1800, stream.begin() + 1806);
    check(id, stream, {520});
  });
}

/// A rest tells little of the motion that follows it, and nothing
/// is known in the first tenth of a second, after a gap neither.
void test_beginnings_are_no_spikes() {
  each_seed(20, [](const Id& id, std::uint64_t seed) {
    Stream stream = motion(seed, 0);
    const Stream moving = motion(seed, 1);
    std::copy(moving.begin() + 1000, moving.end(), stream.begin() + 1000);
    check(id, stream, {});
    host::Recording recording = recording_of(stream, 200);
    for (std::size_t i = 1500; i < kReadings; ++i) recording.imu.samples[i].t_ns += 20000000;  // four periods
    recording.imu.samples[1505].accel[0] += 30;
    recording.imu.samples[1600].accel[0] += 30;
    test::check_true(id, "after a gap", host::spikes_of(recording) == std::vector<std::size_t>{1600});
  });
}

/// Readings that repeat but for a last digit of half the stated noise,
/// or shake with a hundred times that noise from the first one on.
void test_coarse_and_shaken_sensors_have_none() {
  each_seed(20, [](const Id& id, std::uint64_t seed) {
    test::Random random(seed);
    Stream coarse(kReadings), shaken(kReadings);
    for (std::size_t i = 0; i < kReadings; ++i) {
      coarse[i].gyro.fill(random.uniform(0, 1) < 0.01 ? 0.5 * kGyroNoise : 0);
      coarse[i].accel.fill(9);
      for (double& w : shaken[i].gyro) w = 100 * kGyroNoise * random.normal();
      for (double& a : shaken[i].accel) a = 100 * kAccelNoise * random.normal();
    }
    check(id, coarse, {});
    check(id, shaken, {});
    for (int begin = 0; begin + 40 < int(kReadings); begin += 40)
      test::check_true(id, "none at a beginning",
                       spikes_in(Stream(shaken.begin() + begin, shaken.begin() + begin + 40)).empty());
  });
}

/// Knocks and twitches, half sines of 4 to 12 readings on both sensors twice a second, and one of three readings whose
/// end lies on the line to rest.
void test_pulses_are_no_spikes() {
  Stream knock = motion(1, 0);
  for (std::size_t i = 0; i < 3; ++i) knock[500 + i].accel[0] += 9 - 3 * double(i);
  check(Id().add("knock", 1), knock, {});
  for (std::size_t width = 4; width <= 12; ++width)
    for (const double phase : {0.0, 0.3, 0.6}) {
      Stream stream = motion(width, 0);
      for (std::size_t i = 100; i + 100 < kReadings; ++i) {
        const double wave = std::sin(M_PI * std::fmin(1, (double(i % 100) + phase) / double(width)));
        stream[i].gyro[1] += 4 * wave;
        stream[i].accel[2] += 30 * wave;
      }
      check(Id().add("width", width).add("phase", phase), stream, {});
    }
}

/// What comes often is no accident, whatever it looks like: of every second to eighth
/// reading somewhere else 50 at most (each widens what counts as near by 15 / 200, and the
/// first is ten times too far, squared), and of any path of straight pieces one in 200.
void test_what_comes_often_is_none() {
  for (std::size_t period = 2; period <= 8; ++period) {
    Stream stream = motion(2, 0);
    for (std::size_t i = 1000; i < kReadings; i += period) stream[i].accel[1] += 3;
    test::check_true(Id().add("period", period), "few of them", spikes_in(stream).size() <= 50);
  }
  each_seed(200, [](const Id& id, std::uint64_t seed) {
    test::Random random(seed);
    Stream stream = motion(seed, 0);
    double from = 0, to = 0;
    int left = 0, length = 1;
    for (ImuSample& s : stream) {
      if (left == 0) {
        from = to;
        to = random.uniform(-20, 20);
        left = length = 1 + random.index(30);
      }
      s.accel[0] += from + (to - from) * (length - left--) / length;
    }
    test::check_true(id, "one in 200", spikes_in(stream).size() <= kReadings / 200);
  });
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_spikes_are_found);
  RUN_TEST(test_a_spike_takes_no_sound_reading_with_it);
  RUN_TEST(test_motion_is_no_spike);
  RUN_TEST(test_beginnings_are_no_spikes);
  RUN_TEST(test_coarse_and_shaken_sensors_have_none);
  RUN_TEST(test_pulses_are_no_spikes);
  RUN_TEST(test_what_comes_often_is_none);
  return UNITY_END();
}
