// The noise of an IMU's readings from their sixth differences: right for white noise, next to nothing for motion, as
// stated where it is as stated.
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
SixthDifferences<double> differences(const Samples& s, int group = 1) {
  SixthDifferences<double> out;
  out.take(s, 0, s.size() - 1, group);
  return out;
}

/// 20,000 values of which a third count (differences of white noise are correlated): 2 % of the variance is one
/// deviation, and the largest of three axes counts. Means of two and three have a half and a third of it.
void test_white_noise_has_its_own_variance() {
  for (int group = 1; group <= 3; ++group) {
    const SixthDifferences<double> rough = differences(white(0.02, 0.3, 20000 * group, 1), group);
    check_near(Id().add("sensor", "gyro").add("group", group), "variance over the true one", 1.02,
               group * rough.gyro_variance() / (0.02 * 0.02), 0.05);
    check_near(Id().add("sensor", "accel").add("group", group), "variance over the true one", 1.02,
               group * rough.accel_variance() / (0.3 * 0.3), 0.05);
  }
}

/// One axis that shakes must not count for a third.
void test_the_worst_axis_counts() {
  Samples s = white(0, 0, 20000, 2);
  Random random(3);
  for (Reading& r : s.readings) r.accel(2) = random.normal(0.3);
  check_near(Id(), "variance over that axis' own", 1, differences(s).accel_variance() / (0.3 * 0.3), 0.06);
}

/// sin(2 pi f t) comes out as (2 sin(pi f dt))^6 of itself, mean square one half of that squared, over 924.
void test_motion_leaves_what_the_formula_says() {
  for (const double f : {2.0, 5.0, 20.0}) {
    const Id id = Id().add("frequency", f);
    if (!selected(id.text())) continue;
    Samples s;
    for (int i = 0; i < 20000; ++i)
      s.readings.push_back(
          {Vec3<double>::Constant(std::sin(2 * M_PI * f * kInterval * i)), Vec3<double>::Constant(10)});
    const double gain = std::pow(2 * std::sin(M_PI * f * kInterval), 6);
    const SixthDifferences<double> rough = differences(s);
    check_near(id, "variance over the formula", 1, rough.gyro_variance() / (gain * gain / 2 / 924),
               0.01);  // ends of the last period
    check_near(id, "of what stands still", 0, rough.accel_variance(), 1e-25);
  }
}

void test_a_polynomial_of_the_fifth_degree_leaves_nothing() {
  Samples s;
  for (int i = 0; i < 40; ++i) {
    const double x = i;
    s.readings.push_back(
        {Vec3<double>(x * x * x, 1 - x, x * x), Vec3<double>::Constant(x * x * x * x * x - 3 * x * x)});
  }
  check_near(Id(), "gyroscope", 0, differences(s).gyro_variance(), 1e-20);
  check_near(Id(), "accelerometer", 0, differences(s).accel_variance(), 1e-12);  // of values up to 1e8
}

/// A link of 0.2 s among a second of samples: 144 of them are looked at, in means of two and of three.
void test_a_link_is_as_noisy_as_it_looks() {
  const ImuNoise<double> stated{1.7e-4, 2e-5, 2e-3, 3e-4};
  const double root = std::sqrt(kInterval);
  int as_stated = 0;
  double gyro = 0, accel = 0;
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    const Samples quiet = white(1.7e-4 / root, 2e-3 / root, 200, seed),
                  loud = white(5e-3 / root, 0.1 / root, 200, seed);
    const ImuNoise<double> same = noise_in(quiet, stated, quiet.time(80), quiet.time(120), kTick);
    as_stated += same.gyro == stated.gyro && same.accel == stated.accel;
    const ImuNoise<double> more = noise_in(loud, stated, loud.time(80), loud.time(120), kTick);
    gyro += more.gyro / 5e-3 / 200;
    accel += more.accel / 0.1 / 200;
    TEST_ASSERT_TRUE(more.gyro_walk == stated.gyro_walk && more.accel_walk == stated.accel_walk);
  }
  TEST_ASSERT_GREATER_OR_EQUAL_INT(
      198, as_stated);  // each axis' variance scatters by 0.3 to 0.4, and both kinds of means must be beyond 2.25
  check_near(Id(), "gyroscope's density over the true one", 1.05, gyro,
             0.08);  // the largest of three, the smaller of two
  check_near(Id(), "accelerometer's density over the true one", 1.05, accel, 0.08);
}

/// Up to 1.5 times the stated density nothing is added, beyond
/// it what is beyond; samples of one instant tell no density.
void test_what_is_beyond_chance_is_added() {
  check_near(Id().add("seen", 1.49), "density", 1, rougher_density(1.0, 1.49 * 1.49, 1.0), 1e-12);
  check_near(Id().add("seen", 2), "density", std::sqrt(1 + 4 - 2.25), rougher_density(1.0, 4.0, 1.0), 1e-12);
  struct Instant : Samples {
    std::int32_t time(int i) const { return i == 0 ? 6 : 7; }
  } s;
  s.readings = white(1, 1, 200, 1).readings;
  const ImuNoise<double> stated{1e-3, 2e-5, 2e-3, 3e-4};
  const ImuNoise<double> same = noise_in(s, stated, 6, 7, 1e-9);
  TEST_ASSERT_TRUE(same.gyro == stated.gyro && same.accel == stated.accel);
}

/// Tones of 90 and 65 Hz at 200 Hz: means of two stop the first, means of three the second. Their integral is bounded.
void test_a_tone_is_no_noise() {
  const ImuNoise<double> stated{1.7e-4, 2e-5, 2e-3, 3e-4};
  for (const double f : {90.0, 65.0}) {
    Samples s;
    for (int i = 0; i < 200; ++i)
      s.readings.push_back({Vec3<double>::Zero(), Vec3<double>::Constant(2 * std::sin(2 * M_PI * f * kInterval * i))});
    const double as_noise = std::sqrt(differences(s).accel_variance() * kInterval),
                 found = noise_in(s, stated, s.time(80), s.time(120), kTick).accel;
    std::printf("%.0f Hz: %.4f, differences of samples %.4f\n", f, found, as_noise);
    TEST_ASSERT_TRUE(found < (f > 80 ? 0.1 : 0.5) * as_noise);
  }
}

/// Each sensor for itself; samples further away than 48 means do not count, and fewer than nine means tell nothing.
void test_samples_around_the_link_count() {
  const ImuNoise<double> stated{1e-3, 2e-5, 2e-3, 3e-4};
  Samples s = white(0, 0, 500, 1);
  const Samples loud = white(0, 3, 200, 2);
  for (int i = 300; i < 500; ++i)
    s.readings[static_cast<std::size_t>(i)].accel = loud.readings[static_cast<std::size_t>(i - 300)].accel;
  const auto accel = [&](const Samples& from, int first, int last) {
    return noise_in(from, stated, from.time(first), from.time(last), kTick).accel;
  };
  TEST_ASSERT_TRUE(accel(s, 188, 228) == stated.accel);      // up to sample 280
  TEST_ASSERT_TRUE(accel(s, 238, 278) > 10 * stated.accel);  // up to sample 330
  TEST_ASSERT_TRUE(noise_in(s, stated, s.time(380), s.time(420), kTick).gyro == stated.gyro);
  const Samples few = white(0, 3, 17, 2), enough = white(0, 3, 18, 2);
  TEST_ASSERT_TRUE(accel(few, 2, 10) == stated.accel);
  TEST_ASSERT_TRUE(accel(enough, 2, 10) > 10 * stated.accel);
}

}  // namespace

int main(int argc, char** argv) {
  select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_white_noise_has_its_own_variance);
  RUN_TEST(test_the_worst_axis_counts);
  RUN_TEST(test_motion_leaves_what_the_formula_says);
  RUN_TEST(test_a_polynomial_of_the_fifth_degree_leaves_nothing);
  RUN_TEST(test_a_link_is_as_noisy_as_it_looks);
  RUN_TEST(test_what_is_beyond_chance_is_added);
  RUN_TEST(test_a_tone_is_no_noise);
  RUN_TEST(test_samples_around_the_link_count);
  return UNITY_END();
}
