// The device's search for the clocks' offset (clock.h): right where
// it says `found`, no answer where there is none, and bad input.
#include <cmath>
#include <limits>

#include "../replay/simulated_replay.h"
#include "../support/cases.h"
#include "../support/random.h"
#include "device_search.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

host::SimulationResult session_of(const std::string& scenario, std::uint64_t seed, bool drifting) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seed = seed;
  options.camera_rate_hz = seed % 2 == 0 ? 30 : 10;
  if (drifting) options.tracks = host::sim::drifting_tracks();
  return host::simulate(options);
}

/// What is `found`, at any time on the way, is within five of its sigmas and 10
/// ms. Turning devices are found at all; one that is walked need not be: parallax
/// moves the peak by more than the 10 ms, which its windows show by scattering.
void test_found_is_right() {
  test::Random random(5);
  for (const char* scenario : {"rich", "arvr", "nav"}) {
    for (const bool drifting : {false, true}) {
      for (const std::uint64_t seed : {1, 2, 3}) {
        const Id id = Id().add("scenario", scenario).add("drifting", drifting).add("seed", seed);
        test::Feed feed;
        feed.shift_s = random.uniform(-0.4, 0.4);
        if (!test::selected(id.text())) continue;
        const host::SimulationResult session = session_of(scenario, seed, drifting);
        const test::DeviceAnswer answer =
            test::searched(session.recording, test::camera_of(session.nominal.cameras[0]), feed, feed.shift_s);
        std::printf("%s: status %d, error %.2f ms, sigma %.2f ms, correlation %.3f, found after %.0f s\n",
                    id.text().c_str(), answer.result.status, 1e3 * (answer.result.offset_s - feed.shift_s),
                    1e3 * answer.result.sigma_s, answer.result.correlation, answer.found_after_s);
        test::check_between(id, "largest error of what was found, sigmas", 0, answer.worst_of_found, 5);
        test::check_between(id, "largest error of what was found, s", 0, answer.worst_s, 0.01);
        if (std::string(scenario) == "rich") test::check_true(id, "found", answer.result.status == SEGCAL_CLOCK_FOUND);
      }
    }
  }
}

void test_no_answer_at_rest_or_with_wrong_axes() {
  const host::SimulationResult still = test::simulated("still", 20, 1);
  test::check_near(Id(), "at rest", SEGCAL_CLOCK_STILL,
                   test::searched(still.recording, test::camera_of(still.nominal.cameras[0]), {}, 0).result.status, 0);
  const host::SimulationResult rich = test::simulated("rich", 40, 1);
  host::CameraCalibration turned = rich.nominal.cameras[0];
  turned.R_CI = Eigen::Vector3d(1, -1, -1).asDiagonal() * turned.R_CI;
  test::check_near(Id(), "half a turn about", SEGCAL_CLOCK_NO_AGREEMENT,
                   test::searched(rich.recording, test::camera_of(turned), {}, 0).result.status, 0);
}

/// One slice a sample gives the bits of all at once: an image of 60 points is done in less than its 20 samples.
void test_schedule_changes_no_bit() {
  const host::SimulationResult rich = test::simulated("rich", 30, 1);
  const segcal_camera_t camera = test::camera_of(rich.nominal.cameras[0]);
  test::Feed slow;
  slow.slices = 1;
  const test::DeviceAnswer a = test::searched(rich.recording, camera, {}, 0),
                           b = test::searched(rich.recording, camera, slow, 0);
  test::check_near(Id(), "offset", a.result.offset_s, b.result.offset_s, 0);
  test::check_near(Id(), "sigma", a.result.sigma_s, b.result.sigma_s, 0);
}

void test_bad_input_is_refused() {
  static segcal_clock_t clock;
  segcal_camera_t camera = {};
  camera.model = SEGCAL_RADTAN;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CONFIG, segcal_clock_create(&clock, sizeof clock, &camera, 0, 0));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_clock_background(&clock, 1));
  camera.intrinsics[0] = camera.intrinsics[1] = 300;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_clock_create(nullptr, sizeof clock, &camera, 0, 0));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_clock_create(&clock, sizeof clock - 1, &camera, 0, 0));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CONFIG, segcal_clock_create(&clock, sizeof clock, &camera, 0, NAN));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_clock_create(&clock, sizeof clock, &camera, 0, 0));
  segcal_imu_t sample = {};
  sample.gyro[1] = std::numeric_limits<float>::quiet_NaN();
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NOT_FINITE, segcal_clock_push_imu(&clock, &sample));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_clock_push_imu(&clock, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_clock_push_tracks(&clock, 0, nullptr, 3));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_clock_push_tracks(&clock, 0, nullptr, -1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STAMP,
                        segcal_clock_push_tracks(&clock, std::numeric_limits<std::int64_t>::max(), nullptr, 0));
  test::Random random(3);
  for (int i = 0; i < 20000; ++i) {  // any order and any values: the answer stays a number
    sample.t_ns +=
        static_cast<std::int64_t>(random.index(20) == 0 ? random.uniform(-2e9, 3e9) : random.uniform(-1e6, 1e7));
    if (i == 9000)
      sample.t_ns = std::numeric_limits<std::int64_t>::min() + 200000000;  // ns, room for what is added below
    for (float& w : sample.gyro) w = static_cast<float>(random.uniform(-110, 110));
    segcal_clock_push_imu(&clock, &sample);
    segcal_point_t points[30];
    for (segcal_point_t& p : points)
      p = {static_cast<std::uint32_t>(random.index(25)), 0, static_cast<float>(random.uniform(-2e6, 2e6)),
           i % 9 == 0 ? NAN : 4.0F};
    segcal_clock_push_tracks(&clock, sample.t_ns + static_cast<std::int64_t>(random.uniform(-1e8, 1e8)), points, 30);
    segcal_clock_background(&clock, 40);
    if (i == 9000) sample.t_ns = 0;
  }
  segcal_clock_result_t result;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_clock_get(&clock, &result));
  TEST_ASSERT_TRUE(std::isfinite(result.offset_s) && result.status != SEGCAL_CLOCK_FOUND);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_found_is_right);
  RUN_TEST(test_no_answer_at_rest_or_with_wrong_axes);
  RUN_TEST(test_schedule_changes_no_bit);
  RUN_TEST(test_bad_input_is_refused);
  return UNITY_END();
}
