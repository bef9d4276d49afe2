// Stamps taken in callbacks: smoothed back to the sensor's clock; and two streams of an IMU joined.
#include <cmath>
#include <sstream>

#include "../replay/program.h"
#include "../replay/temporary_folder.h"
#include "../support/cases.h"
#include "../support/random.h"
#include "recording.h"
#include "stamps/smooth_stamps.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

struct Log {
  std::vector<double> measured;      ///< s, when the sensor measured
  std::vector<std::int64_t> stamps;  ///< ns, when the callback ran
};

/// An even clock, whose period may change in the middle, as automatic exposure does; callbacks late by 4 ms on average,
/// one in fifty by 50 ms; events follow each other in order. `missing` events in a row are lost at three places.
Log callbacks(std::uint32_t seed, double period, double late, int missing, double slower = 1) {
  test::Random random(seed);
  Log out;
  double t = 10;
  for (int i = 0; i < 1500; ++i) {
    t += i < 750 ? period : slower * period;
    if (i % 400 == 300) t += missing * (i < 750 ? period : slower * period);
    double delay = -0.004 * std::log(1 - random.uniform(0, 1));
    if (random.index(50) == 0) delay += late;
    out.measured.push_back(t);
    auto stamp = static_cast<std::int64_t>(1e9 * (t + delay));
    if (!out.stamps.empty()) stamp = std::max(stamp, out.stamps.back() + 100000);
    out.stamps.push_back(stamp);
  }
  return out;
}

double rms_about_mean(const std::vector<std::int64_t>& stamps, const std::vector<double>& measured) {
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const double off = 1e-9 * static_cast<double>(stamps[i]) - measured[i];
    sum += off;
    squares += off * off;
  }
  const auto n = static_cast<double>(stamps.size());
  return std::sqrt(squares / n - sum / n * sum / n);
}

/// 30 images and 200 samples a second. Exponential delays of 4 ms scatter by 4 ms; a line through 60 of them is good to
/// 0.6 ms, at the ends and at the change of the period to 1.5 ms.
void test_smoothed_stamps_are_the_sensors() {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    for (const double period : {1.0 / 30, 0.005}) {
      for (const int missing : {0, 1, 3}) {
        const Id id = Id().add("seed", seed).add("period", period).add("missing", missing);
        const Log log = callbacks(seed, period, 0.05, missing);
        const host::SmoothedStamps out = host::smooth_stamps(log.stamps);
        test::check_between(id, "jitter before", 0.004, rms_about_mean(log.stamps, log.measured), 0.02);
        // How many of 200 events a second are missing where delays reach
        // ten periods is told to one event: 5 ms, smoothed over 2 s.
        const double allowed = period < 0.02 && missing > 0 ? 0.0025 : 0.0015;
        test::check_between(id, "jitter after", 0, rms_about_mean(out.t_ns, log.measured), allowed);
        if (period > 0.02) test::check_near(id, "events missing", 3 * missing, static_cast<double>(out.missing), 0);
        for (std::size_t i = 1; i < out.t_ns.size(); ++i)
          test::check_true(id, "stamps increase", out.t_ns[i] > out.t_ns[i - 1]);
      }
    }
  }
}

/// Images that were lost here and there, up to a fifth of them, callbacks late by up to 20 ms: most windows that tell
/// the period span a hole then. The holes are told but for a few: an image that is late beside one may count as the
/// next, and is a period off then. (By slopes alone a tenth of them was missed, and stamps scattered by 6 to 11 ms.)
void test_images_lost_at_random() {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    for (const double share : {0.03, 0.1, 0.2}) {
      const Id id = Id().add("seed", seed).add("share", share);
      const Log all = callbacks(seed, 1.0 / 30, 0.02, 0);
      test::Random random(100 + seed);
      Log left;
      for (std::size_t i = 0; i < all.stamps.size(); ++i) {
        if (i > 0 && i + 1 < all.stamps.size() && random.uniform(0, 1) < share) continue;
        left.measured.push_back(all.measured[i]);
        left.stamps.push_back(all.stamps[i]);
      }
      const host::SmoothedStamps out = host::smooth_stamps(left.stamps);
      const auto lost = static_cast<double>(all.stamps.size() - left.stamps.size());
      test::check_near(id, "events missing", lost, static_cast<double>(out.missing), 2 + 0.01 * lost);
      test::check_between(id, "jitter after", 0, rms_about_mean(out.t_ns, left.measured), share > 0.1 ? 0.0045 : 0.003);
    }
  }
}

/// Stamps of a hardware clock stay where they are, but for a microsecond.
void test_even_stamps_stay() {
  std::vector<std::int64_t> even;
  for (int i = 0; i < 500; ++i) even.push_back(1403636579758555392 + i * std::int64_t(5000000));
  const host::SmoothedStamps out = host::smooth_stamps(even);
  test::check_between(Id(), "moved", 0, out.moved_most_s, 1e-6);
  test::check_near(Id(), "missing", 0, static_cast<double>(out.missing), 0);
}

/// The accelerometer runs at another rate and begins later: its values are interpolated to the gyroscope's stamps.
void test_two_streams_are_one_imu() {
  const test::TemporaryFolder folder("segcal_streams");
  std::ostringstream gyro, accel, tracks;
  gyro << "#timestamp [ns],x,y,z\n";
  accel << "#timestamp [ns],x,y,z\n";
  for (int i = 0; i < 200; ++i) gyro << 1000000000 + i * 5000000LL << "," << 0.001 * i << ",0,0\n";
  for (int i = 0; i < 120; ++i)
    accel << 1102000000 + i * 7000000LL << "," << 0.1 * (102 + 7 * i) << ",0,9.8\n";  // 0.1 a ms
  test::write_text(folder.path() / "mav0/imu0/gyro.csv", gyro.str());
  test::write_text(folder.path() / "mav0/imu0/accel.csv", accel.str());
  test::write_text(folder.path() / "mav0/imu0/sensor.yaml",
                   "rate_hz: 200\ngyroscope_noise_density: 1e-3\ngyroscope_random_walk: 1e-5\n"
                   "accelerometer_noise_density: 1e-2\naccelerometer_random_walk: 1e-3\n");
  test::write_text(folder.path() / "mav0/cam0/tracks.csv", "#t,id,u,v\n1200000000,1,2,3\n");
  const host::Recording recording = host::read_recording(folder.path(), 1);
  TEST_ASSERT_EQUAL_INT(167, static_cast<int>(recording.imu.samples.size()));  // 1.105 s, 1.110 s, ... 1.935 s
  for (const host::ImuSample& s : recording.imu.samples) {
    const double ms = 1e-6 * static_cast<double>(s.t_ns - 1000000000);
    test::check_near(Id().add("ms", ms), "gyro", 0.001 * ms / 5, s.gyro[0], 1e-12);
    test::check_near(Id().add("ms", ms), "accel", 0.1 * ms, s.accel[0], 1e-9);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_smoothed_stamps_are_the_sensors);
  RUN_TEST(test_images_lost_at_random);
  RUN_TEST(test_even_stamps_stay);
  RUN_TEST(test_two_streams_are_one_imu);
  return UNITY_END();
}
