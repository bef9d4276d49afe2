// What becomes of segments in calibrations that go wrong, of segments of open length, and of work in the background.
#include <set>

#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

segcal_counters_t counters_of(const segcal_t* device) {
  segcal_counters_t c{};
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_counters(device, &c));
  return c;
}

int kept_in(const segcal_t* device) {
  int n = 0;
  for (int i = 0; i <= SEGCAL_MAX_SEGMENTS; ++i) {
    segcal_segment_t s;
    n += segcal_get_segment(device, i, &s) == SEGCAL_OK && s.kept ? 1 : 0;
  }
  return n;
}

/// Feeds all of a stream; `slices` of background work after each sample. Durations of the segments scored, in s.
std::vector<double> feed(segcal_t* device, const SyntheticStream& s, Way way, int slices) {
  std::vector<double> durations;
  std::set<std::uint32_t> seen;
  for (std::size_t i = 0; i < s.imu.size(); ++i) {
    TEST_ASSERT_GREATER_OR_EQUAL_INT(0, segcal_push_imu(device, &s.imu[i]));
    if (i % 20 == 0) push_frame(device, s.frames[i / 20], way);
    TEST_ASSERT_GREATER_OR_EQUAL_INT(0, segcal_background(device, slices));
    segcal_segment_t scored;
    if (segcal_get_segment(device, -1, &scored) == SEGCAL_OK && seen.insert(scored.serial).second) {
      durations.push_back(1e-9 * static_cast<double>(scored.end_ns - scored.start_ns));
    }
  }
  return durations;
}

/// The stream's corners have a noise of 0.5 px. With a tenth of that stated no segment fits, and a failed calibration
/// leaves none of them to spoil the next one.
void test_misfits_leave_after_a_failed_calibration() {
  static const SyntheticStream twelve(207, 12);
  for (double pixel_sigma : {0.5, 0.05}) {
    const Id id = Id().add("pixel_sigma", pixel_sigma);
    segcal_config_t config = SyntheticStream::config();
    config.keep_segments = 6;
    config.pixel_sigma = pixel_sigma;
    config.trigger_fraction = -1;
    Storage storage(0xFF);
    segcal_t* device = create(&storage, config);
    feed(device, twelve, Way::keyframes, 1000000);
    segcal_flush(device);
    const int kept = kept_in(device);
    check_between(id, "segments kept before", 4, kept, 6);
    const std::uint32_t unsettled = counters_of(device).segments_unsettled;
    const int code = segcal_calibrate(device);
    static segcal_result_t result;
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(device, &result));
    const bool fits = pixel_sigma == 0.5;
    check_near(id, "code", fits ? SEGCAL_OK : SEGCAL_NO_RESULT, code, 0);
    check_near(id, "status", fits ? 1 : 2, result.status, 0);
    check_near(id, "kept afterwards", fits ? kept : 0, kept_in(device), 0);
    check_near(id, "counted", fits ? 0 : kept, counters_of(device).segments_unsettled - unsettled, 0);
    segcal_camera_t camera;
    segcal_get_camera(device, 0, &camera);
    check_true(id, "the calibration moved, unless it failed",
               (camera.intrinsics[0] == config.camera[0].intrinsics[0]) != fits);
  }
}

/// The camera is observed, but it is less than half of theta: the result says what was found, and the device goes on
/// with the calibration that it had.
void test_only_a_calibrated_result_moves_the_device() {
  static const SyntheticStream twelve(211, 12);
  for (bool known_imu : {true, false}) {
    const Id id = Id().add("known_imu", known_imu);
    segcal_config_t config = SyntheticStream::config();
    config.keep_segments = 6;
    config.trigger_fraction = -1;
    for (int i = 11; i < 26; ++i) config.prior_sigma[i] = known_imu ? 1e-6 : 0;  // no data tell more: fixed
    Storage storage(0xFF);
    segcal_t* device = create(&storage, config);
    feed(device, twelve, Way::keyframes, 1000000);
    segcal_flush(device);
    segcal_calibrate(device);
    static segcal_result_t result;
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(device, &result));
    segcal_camera_t camera;
    segcal_get_camera(device, 0, &camera);
    check_near(id, "status", known_imu ? 0 : 1, result.status, 0);
    check_true(id, "fx was found", result.parameter[6].value != config.camera[0].intrinsics[0]);
    check_true(id, "the device's fx stays unless calibrated",
               (camera.intrinsics[0] == config.camera[0].intrinsics[0]) == known_imu);
  }
}

/// Lively motion: segments go on up to twice their length, and lose every second keyframe on the way.
void test_segments_of_open_length() {
  static const SyntheticStream forty(210, 40);
  segcal_config_t config = SyntheticStream::config();
  config.segment_s = 4;
  config.least_segment_s = 2;
  config.most_segment_s = 8;
  config.keep_segments = 4;
  config.trigger_fraction = -1;
  Storage storage(0xFF);
  segcal_t* device = create(&storage, config);
  std::vector<double> durations = feed(device, forty, Way::tracks, 1000000);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(3, durations.size());
  double longest = 0;
  for (double s : durations) {
    check_between(Id().add("segment", s), "duration", 1.9, s, 8.1);  // to half a spacing of keyframes
    longest = std::fmax(longest, s);
  }
  // Longer than segment_s and its spacing: thinned. The flush would end one early, so it is not looked at.
  TEST_ASSERT_TRUE(longest > 4.5);
  segcal_flush(device);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_calibrate(device));
  static segcal_result_t result;
  segcal_get_result(device, &result);
  // Thousands of degrees of freedom and noise as stated: 5 % either way is more than five sigmas of chi2, the rest is
  // for what rounding of stored samples and gates add.
  check_between(Id().add("segments", result.segments), "chi2/dof", 0.8, result.chi2 / result.dof, 1.2);
}

/// Never, one slice, seven, all: the hash is one where work is done when
/// it is due, and while a calibration is under way samples are taken.
void test_slices_change_no_bit() {
  static const SyntheticStream twenty(209, 20);
  std::uint64_t first = 0;
  for (int slices : {0, 1, 7, 1000000}) {
    const Id id = Id().add("slices", slices);
    segcal_config_t config = SyntheticStream::config();
    config.keep_segments = 3;  // after 6 s: then a calibration of its own, in effect after 14 s
    Storage storage(0xFF);
    segcal_t* device = create(&storage, config);
    feed(device, twenty, Way::tracks, slices);
    const segcal_counters_t c = counters_of(device);
    check_near(id, "calibrations begun", 1, c.calibrations, 0);
    check_near(id, "segments missed", 4, c.segments_missed, 0);
    check_near(id, "late", 0, c.slices_late, 0);
    segcal_flush(device);
    const std::uint64_t hash = segcal_result_hash(device);
    if (first == 0) first = hash;
    check_true(id, "another hash", hash == first);
    TEST_ASSERT_EQUAL_INT(0, segcal_background(device, 0));
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_only_a_calibrated_result_moves_the_device);
  RUN_TEST(test_misfits_leave_after_a_failed_calibration);
  RUN_TEST(test_segments_of_open_length);
  RUN_TEST(test_slices_change_no_bit);
  return UNITY_END();
}
