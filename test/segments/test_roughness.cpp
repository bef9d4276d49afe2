// The noise of an IMU's readings from their sixth differences: right for white noise, next to nothing for motion, as stated where it is as stated.
#include <vector>

#include "../support/cases.h"
#include "../support/random.h"
#include "sensors/roughness.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;
using namespace SEGCAL_NS;
using Reading = InertialReading<double>;

/// Every 5 ms, in microseconds.
struct Samples {
  std::vector<Reading> readings;
  int size() const { return static_cast<int>(readings.size()); }
  std::int32_t time(int i) const { return 5000 * i; }
  Reading reading(int i) const { return readings[static_cast<std::size_t>(i)]; }
  std::int32_t last() const { return time(size() - 1); }
};
constexpr double kInterval = 0.005, kTick = 1e-6;

Samples white(double gyro, double accel, int n, std::uint32_t seed) {
  Random random(seed);
  Samples out;
  for (int i = 0; i < n; ++i) out.readings.push_back({random.vector(gyro), random.vector(accel)});
  return out;
}
SixthDifferences<double> differences(const Samples& s) {
  SixthDifferences<double> out;
  for (const Reading& r : s.readings) out.push(r);
  return out;
}

/// 3 x 20,000 values of which a third count (differences of white noise are correlated): 1 % of the variance is one deviation.
void test_white_noise_has_its_own_variance() {
  const SixthDifferences<double> rough = differences(white(0.02, 0.3, 20000, 1));
  check_near(Id().add("sensor", "gyro"), "variance over the true one", 1, rough.gyro_variance() / (0.02 * 0.02), 0.04);
  check_near(Id().add("sensor", "accel"), "variance over the true one", 1, rough.accel_variance() / (0.3 * 0.3), 0.04);
}

/// sin(2 pi f t) comes out as (2 sin(pi f dt))^6 of itself, mean square one half of that squared, over 924.
void test_motion_leaves_what_the_formula_says() {
  for (const double f : {2.0, 5.0, 20.0}) {
    const Id id = Id().add("frequency", f);
    if (!selected(id.text())) continue;
    Samples s;
    for (int i = 0; i < 20000; ++i) s.readings.push_back({Vec3<double>::Constant(std::sin(2 * M_PI * f * kInterval * i)), Vec3<double>::Constant(10)});
    const double gain = std::pow(2 * std::sin(M_PI * f * kInterval), 6);
    const SixthDifferences<double> rough = differences(s);
    check_near(id, "variance over the formula", 1, rough.gyro_variance() / (gain * gain / 2 / 924), 0.01);   // ends of the last period
    check_near(id, "of what stands still", 0, rough.accel_variance(), 1e-25);
  }
}

void test_a_polynomial_of_the_fifth_degree_leaves_nothing() {
  Samples s;
  for (int i = 0; i < 40; ++i) {
    const double x = i;
    s.readings.push_back({Vec3<double>(x * x * x, 1 - x, x * x), Vec3<double>::Constant(x * x * x * x * x - 3 * x * x)});
  }
  check_near(Id(), "gyroscope", 0, differences(s).gyro_variance(), 1e-20);
  check_near(Id(), "accelerometer", 0, differences(s).accel_variance(), 1e-12);  // of values up to 1e8
}

/// A link of 0.2 s: 41 samples. The variance then scatters by a fifth.
void test_a_link_is_as_noisy_as_it_looks() {
  const ImuNoise<double> stated{1.7e-4, 2e-5, 2e-3, 3e-4};
  int as_stated = 0;
  double gyro = 0, accel = 0;
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    const Samples quiet = white(1.7e-4 / std::sqrt(kInterval), 2e-3 / std::sqrt(kInterval), 41, seed);
    const ImuNoise<double> same = noise_in(quiet, stated, 0, quiet.last(), kTick);
    as_stated += same.gyro == stated.gyro && same.accel == stated.accel;
    const Samples loud = white(5e-3 / std::sqrt(kInterval), 0.1 / std::sqrt(kInterval), 41, seed);
    const ImuNoise<double> more = noise_in(loud, stated, 0, loud.last(), kTick);
    gyro += more.gyro / 5e-3 / 200;
    accel += more.accel / 0.1 / 200;
    TEST_ASSERT_TRUE(more.gyro_walk == stated.gyro_walk && more.accel_walk == stated.accel_walk);
  }
  TEST_ASSERT_GREATER_OR_EQUAL_INT(199, as_stated);   // five deviations of a variance to the limit
  check_near(Id(), "gyroscope's density over the true one", 1, gyro, 0.03);
  check_near(Id(), "accelerometer's density over the true one", 1, accel, 0.03);
}

/// Each sensor for itself, from the samples between the two times only, and from nine on.
void test_only_the_samples_of_the_link_count() {
  const ImuNoise<double> stated{1e-3, 2e-5, 2e-3, 3e-4};
  Samples s = white(0, 0, 120, 1);
  for (int i = 60; i < 120; ++i) s.readings[static_cast<std::size_t>(i)].accel(1) += i % 2 ? 1 : -1;
  const auto accel = [&](int first, int last) { return noise_in(s, stated, s.time(first), s.time(last), kTick).accel; };
  TEST_ASSERT_TRUE(accel(0, 59) == stated.accel);
  TEST_ASSERT_TRUE(accel(60, 67) == stated.accel);
  // +1, -1 alternating: a sixth difference of 64 on one axis of three, squared over 924.
  const double seen = 64.0 * 64 / 924 / 3 * kInterval;
  check_near(Id(), "nine samples", std::sqrt(seen - 1.25 * 4e-6), accel(60, 68), 1e-12);
  TEST_ASSERT_TRUE(noise_in(s, stated, s.time(60), s.time(119), kTick).gyro == stated.gyro);
}

}  // namespace

int main(int argc, char** argv) {
  select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_white_noise_has_its_own_variance);
  RUN_TEST(test_motion_leaves_what_the_formula_says);
  RUN_TEST(test_a_polynomial_of_the_fifth_degree_leaves_nothing);
  RUN_TEST(test_a_link_is_as_noisy_as_it_looks);
  RUN_TEST(test_only_the_samples_of_the_link_count);
  return UNITY_END();
}
