// Single readings that no motion explains: each is found, and no reading of a motion is lost, however suddenly it begins.
#include <algorithm>
#include <cmath>
#include <vector>

#include "../support/cases.h"
#include "../support/random.h"
#include "diagnose/spike_gate.h"

using namespace host;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr double kGyroNoise = 2.4e-3, kAccelNoise = 0.028;   // of one reading at 200 Hz and the default densities
constexpr int kReadings = 2000;                              // 10 s

template <class S>
using Stream = std::vector<InertialReading<S>>;

/// Turns and swings of 1 to 2 Hz, with white noise.
template <class S>
Stream<S> motion(std::uint64_t seed, double size) {
  test::Random random(seed);
  Stream<S> out;
  for (int i = 0; i < kReadings; ++i) {
    const double t = i / 200.0;
    InertialReading<S> r;
    for (int k = 0; k < 3; ++k) {
      r.gyro(k) = S(size * 2 * std::sin(2 * M_PI * (1 + 0.3 * k) * t) + kGyroNoise * random.normal());
      r.accel(k) = S((k == 2 ? 9.8 : 0) + size * 5 * std::cos(2 * M_PI * (1.2 + 0.3 * k) * t) + kAccelNoise * random.normal());
    }
    out.push_back(r);
  }
  return out;
}

struct Passed {
  std::vector<int> taken, spikes;
};

/// As spikes_of() does.
template <class S>
Passed pass(const Stream<S>& stream) {
  SpikeGate<S> gate;
  gate.begin(S(kGyroNoise), S(kAccelNoise));
  Passed out;
  for (int i = 0; i < int(stream.size()); ++i) {
    const InertialReading<S>& r = stream[std::size_t(i)];
    if (gate.holds() && gate.is_spike(r)) {
      out.spikes.push_back(int(gate.held_ns()));
      gate.leave_out();
    } else if (gate.holds()) {
      out.taken.push_back(int(gate.held_ns()));
      gate.follow(gate.held());
    }
    if (gate.jumps(r)) {
      gate.hold(i, r);
    } else {
      out.taken.push_back(i);
      gate.follow(r);
    }
  }
  return out;
}

/// All but `spikes`, in order; one that is held at the end is still out.
void check(const Id& id, const Passed& passed, const std::vector<int>& spikes) {
  test::check_true(id, "the spikes that were put in, and no others", passed.spikes == spikes);
  std::vector<int> expected;
  for (int i = 0; i < kReadings; ++i)
    if (std::find(spikes.begin(), spikes.end(), i) == spikes.end()) expected.push_back(i);
  test::check_true(id, "all others are taken, in order", passed.taken == expected);
}

/// From 0.35 rad/s and 1.6 m/s^2, eight times what noise and motion bend these streams by, to full scale; either sensor, any axis.
template <class S>
void test_spikes_are_found() {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::Random random(seed + 100);
    const Id id = Id().add("seed", seed);
    if (!test::selected(id.text())) continue;
    Stream<S> stream = motion<S>(seed, seed % 2 ? 1 : 0.1);
    std::vector<int> spikes;
    for (int at = 100; at < kReadings - 100; at += 50) {
      const int axis = int(random.uniform(0, 5.99));
      const double share = std::pow(10.0, -random.uniform(0, 2));   // of full scale: 0.01 to 1
      S& value = axis < 3 ? stream[std::size_t(at)].gyro(axis) : stream[std::size_t(at)].accel(axis - 3);
      value += S((random.uniform(0, 1) < 0.5 ? -1 : 1) * share * (axis < 3 ? 35 : 157));
      spikes.push_back(at);
    }
    check(id, pass(stream), spikes);
  }
}

/// A knock that goes on, a jump to another rate, a start from rest, single samples lost.
template <class S>
void test_motion_is_never_lost() {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Id id = Id().add("seed", seed);
    if (!test::selected(id.text())) continue;
    Stream<S> stream = motion<S>(seed, 1);
    for (std::size_t i = 500; i < 503; ++i) stream[i].accel(1) += S(60);                                   // 15 ms; a spike soon after it
    stream[520].accel(2) += S(4);
    for (std::size_t i = 900; i < 905; ++i) stream[i].accel(0) += S(40 * (i % 2 ? -1 : 1));                // it rings
    for (std::size_t i = 1200; i < stream.size(); ++i) stream[i].gyro(2) += S(8);
    for (std::size_t i = 1500; i < 1700; ++i) stream[i] = stream[1500];
    stream.erase(stream.begin() + 1800, stream.begin() + 1806);
    stream.insert(stream.end(), 6, stream.back());
    check(id, pass(stream), {520});
  }
}

/// Nothing is known of the scale in the first tenth of a second, nor after a rest in which nothing but noise was seen.
template <class S>
void test_a_rest_does_not_make_motion_a_spike() {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Id id = Id().add("seed", seed);
    if (!test::selected(id.text())) continue;
    Stream<S> stream = motion<S>(seed, 0);
    const Stream<S> moving = motion<S>(seed, 1);
    std::copy(moving.begin() + 1000, moving.end(), stream.begin() + 1000);
    check(id, pass(stream), {});
  }
}

/// Its readings repeat but for a last digit of half the stated noise, or shake with a hundred times that noise from the first one on.
template <class S>
void test_coarse_and_shaken_sensors_lose_nothing() {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Id id = Id().add("seed", seed);
    if (!test::selected(id.text())) continue;
    test::Random random(seed);
    Stream<S> coarse(kReadings), shaken(kReadings);
    for (int i = 0; i < kReadings; ++i) {
      coarse[std::size_t(i)] = {Vec3<S>::Constant(S(random.uniform(0, 1) < 0.01 ? 0.5 * kGyroNoise : 0)), Vec3<S>::Constant(S(9))};
      InertialReading<S>& r = shaken[std::size_t(i)];
      for (int k = 0; k < 3; ++k) {
        r.gyro(k) = S(100 * kGyroNoise * random.normal());
        r.accel(k) = S(100 * kAccelNoise * random.normal());
      }
    }
    check(id, pass(coarse), {});
    check(id, pass(shaken), {});
    for (int begin = 0; begin + 40 < kReadings; begin += 40)
      test::check_true(id, "none at a beginning", pass(Stream<S>(shaken.begin() + begin, shaken.begin() + begin + 40)).spikes.empty());
  }
}

/// Lost of a stream.
template <class S>
std::size_t lost(const Stream<S>& stream) {
  return pass(stream).spikes.size();
}

/// Knocks and twitches, half sines of 4 to 12 readings on either sensor twice a second, and one whose end lies on the line to rest.
template <class S>
void test_pulses_are_motion() {
  Stream<S> knock = motion<S>(1, 0);
  knock[500].accel(0) += S(9);
  knock[501].accel(0) += S(6);
  check(Id().add("knock", 1), pass(knock), {});
  for (int width = 4; width <= 12; ++width) {
    for (double phase : {0.0, 0.3, 0.6}) {
      const Id id = Id().add("width", width).add("phase", phase);
      if (!test::selected(id.text())) continue;
      Stream<S> stream = motion<S>(std::uint64_t(width), 0);
      for (int begin = 100; begin + width < kReadings; begin += 100)
        for (int k = 0; k <= width; ++k) {
          const double wave = std::sin(M_PI * std::fmin(1, (k + phase) / width));
          stream[std::size_t(begin + k)].gyro(1) += S(4 * wave);
          stream[std::size_t(begin + k)].accel(2) += S(30 * wave);
        }
      check(id, pass(stream), {});
    }
  }
}

/// What comes often is no accident, whatever it looks like: every second to eighth reading somewhere else costs 50 of them at most (each
/// widens what counts as near by 15 / 200, and the first is ten times too far, squared), and any path of straight pieces one in 200.
template <class S>
void test_what_comes_often_is_taken() {
  for (int period = 2; period <= 8; ++period) {
    Stream<S> stream = motion<S>(2, 0);
    for (std::size_t i = 1000; i < stream.size(); i += std::size_t(period)) stream[i].accel(1) += S(3);
    test::check_true(Id().add("period", period), "all but a few", lost(stream) <= 50);
  }
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Id id = Id().add("seed", seed);
    if (!test::selected(id.text())) continue;
    test::Random random(seed);
    Stream<S> stream = motion<S>(seed, 0);
    double from = 0, to = 0;
    for (int i = 0, left = 0, length = 1; i < kReadings; ++i, --left) {
      if (left == 0) {
        from = to;
        to = random.uniform(-20, 20);
        left = length = 1 + random.index(30);
      }
      stream[std::size_t(i)].accel(0) += S(from + (to - from) * (length - left) / length);
    }
    test::check_true(id, "one in 200", lost(stream) <= kReadings / 200);
  }
}

template <class S>
void run() {
  RUN_TEST(test_spikes_are_found<S>);
  RUN_TEST(test_motion_is_never_lost<S>);
  RUN_TEST(test_a_rest_does_not_make_motion_a_spike<S>);
  RUN_TEST(test_coarse_and_shaken_sensors_lose_nothing<S>);
  RUN_TEST(test_pulses_are_motion<S>);
  RUN_TEST(test_what_comes_often_is_taken<S>);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  run<float>();
  run<double>();
  return UNITY_END();
}
