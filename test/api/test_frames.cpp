// Which segments share a frame of reference, through the C API: the user's own odometry keeps its map over a gap in the
// IMU's data, the filter starts anew, and a new session is a new frame for both.
#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

enum class Break { none, gap, session };

/// Twelve seconds, interrupted in the middle; six segments of two seconds are kept at most.
segcal_result_t calibrate(Way way, Break how) {
  static const SyntheticStream twelve(203, 12);
  segcal_config_t config = SyntheticStream::config();
  config.keep_segments = 6;
  config.strategy = SEGCAL_MULTI_SESSION;
  Storage storage(0xFF);
  segcal_t* device = create(&storage, config);
  for (std::size_t i = 0; i < twelve.imu.size(); ++i) {
    const bool missing = i > 1200 && i < 1260;  // 0.3 s
    if (how == Break::session && i == 1200) TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_new_session(device));
    if (how == Break::gap && missing) continue;
    TEST_ASSERT_GREATER_OR_EQUAL_INT(0, segcal_push_imu(device, &twelve.imu[i]));
    if (i % 20 == 0) push_frame(device, twelve.frames[i / 20], way);
  }
  segcal_flush(device);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_calibrate(device));
  segcal_result_t result;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(device, &result));
  TEST_ASSERT_GREATER_OR_EQUAL_INT(4, result.segments);  // some on either side of the break
  return result;
}

void test_an_unbroken_stream_is_one_partition() {
  TEST_ASSERT_EQUAL_INT(1, calibrate(Way::keyframes, Break::none).partitions);
  TEST_ASSERT_EQUAL_INT(1, calibrate(Way::tracks, Break::none).partitions);
}

void test_own_odometry_keeps_its_frame_over_a_gap() {
  TEST_ASSERT_EQUAL_INT(1, calibrate(Way::keyframes, Break::gap).partitions);
}

void test_the_filter_has_a_new_frame_after_a_gap() {
  TEST_ASSERT_EQUAL_INT(2, calibrate(Way::tracks, Break::gap).partitions);
}

void test_a_new_session_is_a_new_frame() {
  TEST_ASSERT_EQUAL_INT(2, calibrate(Way::keyframes, Break::session).partitions);
  TEST_ASSERT_EQUAL_INT(2, calibrate(Way::tracks, Break::session).partitions);
}

/// The filter weighs by the walk that is stated for the tracks.
void test_a_walk_of_the_tracks_reaches_the_filter() {
  segcal_state_t state[2];
  for (int i = 0; i < 2; ++i) {
    segcal_config_t config = SyntheticStream::config();
    config.track_walk = i == 0 ? 0 : 0.9;
    Storage storage(0xFF);
    segcal_t* device = create(&storage, config);
    for (std::size_t k = 0; k < 1600; ++k) {  // before any calibration
      TEST_ASSERT_GREATER_OR_EQUAL_INT(0, segcal_push_imu(device, &stream().imu[k]));
      if (k % 20 == 0) push_frame(device, stream().frames[k / 20], Way::tracks);
    }
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_state(device, &state[i]));
  }
  const double moved = std::abs(state[0].p_GI[0] - state[1].p_GI[0]);
  TEST_ASSERT_TRUE(moved > 1e-5 && moved < 0.05);  // m: another weight, the same path
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_an_unbroken_stream_is_one_partition);
  RUN_TEST(test_own_odometry_keeps_its_frame_over_a_gap);
  RUN_TEST(test_the_filter_has_a_new_frame_after_a_gap);
  RUN_TEST(test_a_new_session_is_a_new_frame);
  RUN_TEST(test_a_walk_of_the_tracks_reaches_the_filter);
  return UNITY_END();
}
