// A device that condenses: what it remembers, that it knows more
// by it, and that no schedule of its background changes a bit.
#include <string>

#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

const SyntheticStream& stream_of_30_s() { return long_stream<30>(); }

segcal_config_t config(bool condense) {
  segcal_config_t c = SyntheticStream::config();  // segments of 2 s
  c.keep_segments = 4;  // from two, the first release is too far off for what is linearised there
  c.strategy = SEGCAL_MULTI_SESSION;
  c.condense = condense ? 1 : 0;
  c.calibration_window = 1;
  return c;
}

void feed(segcal_t* device, int slices) {
  for (std::size_t i = 0; i < stream_of_30_s().imu.size(); ++i) {
    segcal_push_imu(device, &stream_of_30_s().imu[i]);
    if (i % 20 == 0) push_frame(device, stream_of_30_s().frames[i / 20], Way::tracks);
    segcal_background(device, slices);
  }
  segcal_flush(device);
  segcal_calibrate(device);
}

segcal_result_t result_of(segcal_t* device) {
  segcal_result_t r;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(device, &r));
  return r;
}

int condensed_segments(segcal_t* device) {
  int n = 0;
  segcal_epoch_t e;
  for (int i = 0; segcal_get_epoch(device, i, &e) == SEGCAL_OK; ++i) n += e.segments;
  return n;
}

void test_more_is_known_and_honestly() {
  Storage plain(0), condensing(0);
  segcal_t *a = create(&plain, config(false)), *b = create(&condensing, config(true));
  feed(a, 1000000);
  feed(b, 1000000);
  const segcal_result_t four = result_of(a), all = result_of(b);
  TEST_ASSERT_EQUAL_INT(SEGCAL_CALIBRATED, all.status);
  // 15 segments in 30 s, of which the filter's start takes one: four are kept, one is missed beside the first
  // calibration.
  TEST_ASSERT_GREATER_OR_EQUAL_INT(6, condensed_segments(b));
  segcal_epoch_t e;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_epoch(b, 0, &e));
  TEST_ASSERT_EQUAL_INT(all.n_parameters, e.n_parameters);
  double ratio = 0, squares = 0;
  for (int i = 0; i < all.n_parameters; ++i) {
    const Id id = Id().add("parameter", all.parameter[i].name);
    ratio += all.parameter[i].sigma / four.parameter[i].sigma / all.n_parameters;
    // The device is the nominal one: values as in the configuration.
    const double error = (all.parameter[i].value - all.parameter[i].initial) / all.parameter[i].sigma;
    check_between(id, "error in sigmas", -5, error, 5);
    squares += error * error / all.n_parameters;
    // What an epoch alone tells cannot be better than all.
    check_between(id, "sigma of the epoch over that of all", 1, 1.001 * e.sigma[i] / all.parameter[i].sigma, 1e6);
  }
  // Four of at least ten segments: sigmas would fall to 0.6 if all were alike; the best four were kept.
  check_between(Id(), "mean ratio of sigmas", 0.4, ratio, 0.8);
  check_between(Id(), "mean squared error in sigmas", 0.2, squares, 2.5);
}

void test_no_schedule_changes_a_bit() {
  std::uint64_t first = 0;
  for (int slices : {40, 300, 1000000}) {
    Storage storage(0xA5);
    segcal_t* device = create(&storage, config(true));
    feed(device, slices);
    const std::uint64_t hash = segcal_result_hash(device);
    if (first == 0) first = hash;
    const Id id = Id().add("slices", slices);
    check_true(id, "another hash", hash == first);
    check_true(id, "nothing condensed", condensed_segments(device) > 0);
  }
}

void test_what_is_not_there_is_refused() {
  Storage storage(0);
  segcal_config_t c = config(true);
  c.condense = 2;
  segcal_t* device = nullptr;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CONFIG, segcal_create(&device, &c, storage.data, segcal_storage_bytes()));
  device = create(&storage, config(true));
  segcal_epoch_t e;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_epoch(device, 0, &e));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_epoch(device, -1, &e));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_epoch(nullptr, 0, &e));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_epoch(device, 0, nullptr));
}

/// A session of its own starts with an empty memory.
void test_single_sessions_forget() {
  Storage storage(0);
  segcal_config_t c = config(true);
  c.strategy = SEGCAL_SINGLE_SESSION;
  segcal_t* device = create(&storage, c);
  feed(device, 1000000);
  TEST_ASSERT_GREATER_THAN_INT(0, condensed_segments(device));
  segcal_new_session(device);
  TEST_ASSERT_EQUAL_INT(0, condensed_segments(device));
}

/// Samples [from, until) of the stream, with the caller's odometry; images are `off_px` beside where they should be.
void feed_keyframes(segcal_t* device, std::size_t from, std::size_t until, float off_px) {
  for (std::size_t i = from; i < until; ++i) {
    segcal_push_imu(device, &stream_of_30_s().imu[i]);
    if (i % 20 == 0) {
      SyntheticStream::Frame frame = stream_of_30_s().frames[i / 20];
      for (segcal_point_t& p : frame.points) p.u += off_px;
      push_frame(device, frame, Way::keyframes);
    }
    segcal_background(device, 1000000);
  }
  segcal_flush(device);
  segcal_calibrate(device);
}

/// Two seconds of images beside their place fit, with another principal point; all that is older contradicts them.
void test_one_segment_convicts_nobody() {
  Storage storage(0);
  segcal_config_t c = config(true);
  c.keep_segments = 6;
  segcal_t* device = create(&storage, c);
  feed_keyframes(device, 0, 5000, 0);
  segcal_counters_t before, after;
  segcal_get_counters(device, &before);
  feed_keyframes(device, 5000, 5405, 2);
  segcal_get_counters(device, &after);
  TEST_ASSERT_EQUAL_UINT32(before.segments_outdated, after.segments_outdated);
  TEST_ASSERT_EQUAL_INT(SEGCAL_CALIBRATED, result_of(device).status);
  TEST_ASSERT_EQUAL_INT(6, result_of(device).segments);
}

/// Segments in which nothing is seen say nothing about whether theta is still what it was: one that did not fit, and a
/// hand over the lens, do not end the condensing.
void test_a_covered_camera_is_no_misfit() {
  Storage storage(0);
  segcal_t* device = create(&storage, config(true));
  feed_keyframes(device, 0, 3000, 0);
  const auto feed_part = [device](std::size_t from, std::size_t until, bool lost, bool covered) {
    for (std::size_t i = from; i < until; ++i) {
      segcal_push_imu(device, &stream_of_30_s().imu[i]);
      segcal_background(device, 1000000);
      if (i % 20 != 0) continue;
      SyntheticStream::Frame frame = stream_of_30_s().frames[i / 20];
      if (lost) frame.state.p_GI[0] += 0.5 * static_cast<double>(i / 20 % 3);
      if (covered) frame.points.clear();
      push_frame(device, frame, Way::keyframes);
    }
    segcal_flush(device);
  };
  feed_part(3000, 3400, true, false);
  feed_part(3400, 4600, false, true);
  const int before = condensed_segments(device);
  segcal_counters_t dark, good;
  segcal_get_counters(device, &dark);
  TEST_ASSERT_EQUAL_UINT32(1, dark.segments_unsettled);
  TEST_ASSERT_EQUAL_UINT32(3, dark.segments_discarded);
  feed_part(4600, 6000, false, false);
  segcal_get_counters(device, &good);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(before + 3, condensed_segments(device));            // 7 s of segments of 2 s
  TEST_ASSERT_EQUAL_UINT32(dark.calibrations_published, good.calibrations_published);  // the database did not collect
}

/// While a calibration that was asked for moves the kept segments, they are in nobody's hash.
void test_an_asked_calibration_shows_when_it_is_done() {
  Storage storage(0);
  segcal_t* device = create(&storage, config(true));
  feed(device, 1000000);
  std::uint64_t last = segcal_result_hash(device);
  int changes = 0, answer = 1;
  segcal_request_calibration(device);
  while (answer == 1) {
    answer = segcal_flush_slices(device, 20);
    const std::uint64_t hash = segcal_result_hash(device);
    changes += hash != last ? 1 : 0;
    last = hash;
  }
  TEST_ASSERT_EQUAL_INT(0, answer);
  // When it begins, the segments leave the hash; when it takes effect, its result comes in; at the end, the segments.
  TEST_ASSERT_LESS_OR_EQUAL_INT(3, changes);
}

/// joint_filter calibrates by its filter alone, also beside the caller's own odometry.
void test_a_joint_filter_calibrates_no_segments() {
  Storage storage(0);
  segcal_config_t c = config(false);
  c.joint_filter = 1;
  segcal_t* device = create(&storage, c);
  for (std::size_t i = 0; i < 5000; ++i) {
    segcal_push_imu(device, &stream_of_30_s().imu[i]);
    if (i % 20 == 0) push_frame(device, stream_of_30_s().frames[i / 20], Way::keyframes);
    segcal_background(device, 1000000);
  }
  segcal_counters_t counters;
  segcal_get_counters(device, &counters);
  TEST_ASSERT_EQUAL_UINT32(0, counters.calibrations);
}

/// Parts of 7.5 s, each a session of its own: the device calibrates again of its own when it has condensed three times
/// what the last one was made from, however many sessions that took.
void test_short_sessions_add_up() {
  Storage storage(0);
  segcal_config_t c = config(true);
  c.keep_segments = 2;
  segcal_t* device = create(&storage, c);
  segcal_counters_t counters;
  for (int lap = 0; lap < 2; ++lap) {
    for (std::size_t part = 0; part < 4; ++part) {
      for (std::size_t i = 1500 * part; i < 1500 * (part + 1); ++i) {
        segcal_push_imu(device, &stream_of_30_s().imu[i]);
        if (i % 20 == 0) push_frame(device, stream_of_30_s().frames[i / 20], Way::keyframes);
        segcal_background(device, 1000000);
      }
      segcal_new_session(device);
    }
  }
  segcal_get_counters(device, &counters);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(2, static_cast<int>(counters.calibrations_published));
}

int column_of(segcal_t* device, const char* name) {
  const segcal_result_t r = result_of(device);
  for (int i = 0; i < r.n_parameters; ++i) {
    if (std::string(r.parameter[i].name) == name) return i;
  }
  return -1;
}

/// The principal point is somewhere else in the second session.
void test_a_change_is_followed_and_dated() {
  constexpr double kStep = 3;  // px
  Storage storage(0);
  segcal_t* device = create(&storage, config(true));
  segcal_change_t change;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_change(device, 0, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_change(nullptr, 0, &change));
  feed_keyframes(device, 0, 2600, 0);
  const segcal_result_t before = result_of(device);
  const int cx = column_of(device, "cam0.cx");
  for (int i = -1; i < 2; ++i) TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_change(device, i, &change));
  segcal_new_session(device);

  // Two segments: a contradiction, and too few to tell what is right. The release from before stays.
  feed_keyframes(device, 2600, 3500, kStep);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_change(device, -1, &change));
  TEST_ASSERT_EQUAL_INT(1, change.open);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_change(device, 0, &change));
  TEST_ASSERT_EQUAL_INT(SEGCAL_CALIBRATED, result_of(device).status);
  TEST_ASSERT_EQUAL_DOUBLE(before.parameter[cx].value, result_of(device).parameter[cx].value);

  feed_keyframes(device, 3500, 6000, kStep);
  const segcal_result_t after = result_of(device);
  TEST_ASSERT_EQUAL_INT(SEGCAL_CALIBRATED, after.status);
  check_between(Id(), "error of cx, sigmas", -4,
                (after.parameter[cx].value - after.parameter[cx].initial - kStep) / after.parameter[cx].sigma, 4);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_change(device, -1, &change));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_change(device, 0, &change));
  TEST_ASSERT_EQUAL_INT(0, change.open);
  TEST_ASSERT_EQUAL_UINT32(0, change.before_session);
  TEST_ASSERT_EQUAL_UINT32(1, change.after_session);
  TEST_ASSERT_TRUE(change.t_ns >= stream_of_30_s().imu[2600].t_ns && change.t_ns < stream_of_30_s().imu[3000].t_ns);
  TEST_ASSERT_EQUAL_INT(after.n_parameters, change.n_parameters);
  check_between(Id(), "step of cx, px", kStep - 4 * change.sigma[cx], change.step[cx], kStep + 4 * change.sigma[cx]);
  segcal_counters_t counters;
  segcal_get_counters(device, &counters);
  TEST_ASSERT_GREATER_OR_EQUAL_UINT32(4, counters.segments_outdated);  // what the first release was made from
}

/// A contradiction, and then a hand over the lens for much longer than segments are waited for: nothing says that what
/// was known before still holds, and nothing may confirm it.
void test_nothing_seen_decides_nothing() {
  Storage storage(0);
  segcal_config_t c = config(true);
  c.keep_segments = 5;  // nothing is condensed before the change: it is the kept ones that are contradicted
  segcal_t* device = create(&storage, c);
  segcal_new_session(device);
  feed_keyframes(device, 0, 2020, 0);
  TEST_ASSERT_EQUAL_INT(0, condensed_segments(device));
  segcal_new_session(device);
  feed_keyframes(device, 2020, 2440, 3);  // the one that contradicts, and none after it
  segcal_change_t change;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_change(device, -1, &change));
  TEST_ASSERT_EQUAL_UINT32(1, change.before_session);
  TEST_ASSERT_EQUAL_UINT32(2, change.after_session);
  segcal_counters_t before, after;
  segcal_get_counters(device, &before);
  for (int lap = 0; lap < 2; ++lap) {  // 30 segments; three times five are waited for
    segcal_new_session(device);
    for (std::size_t i = 0; i < stream_of_30_s().imu.size(); ++i) {
      segcal_push_imu(device, &stream_of_30_s().imu[i]);
      segcal_background(device, 1000000);
      if (i % 20 != 0) continue;
      SyntheticStream::Frame frame = stream_of_30_s().frames[i / 20];
      frame.points.clear();
      push_frame(device, frame, Way::keyframes);
    }
    segcal_flush(device);
    segcal_calibrate(device);
  }
  segcal_get_counters(device, &after);
  TEST_ASSERT_GREATER_OR_EQUAL_UINT32(before.segments_closed + 24, after.segments_closed);
  TEST_ASSERT_EQUAL_UINT32(before.calibrations_published, after.calibrations_published);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_change(device, -1, &change));
}

void test_no_change_is_none() {
  Storage storage(0);
  segcal_t* device = create(&storage, config(true));
  segcal_change_t change;
  for (std::size_t part = 0; part < 3; ++part) {
    feed_keyframes(device, 2000 * part, 2000 * (part + 1), 0);
    segcal_new_session(device);
  }
  for (int i = -1; i < 1; ++i) TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_change(device, i, &change));
  segcal_epoch_t first, second;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_epoch(device, 0, &first));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_epoch(device, 1, &second));  // each session its own
  TEST_ASSERT_EQUAL_INT(SEGCAL_CALIBRATED, result_of(device).status);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_more_is_known_and_honestly);
  RUN_TEST(test_no_schedule_changes_a_bit);
  RUN_TEST(test_what_is_not_there_is_refused);
  RUN_TEST(test_single_sessions_forget);
  RUN_TEST(test_one_segment_convicts_nobody);
  RUN_TEST(test_a_change_is_followed_and_dated);
  RUN_TEST(test_nothing_seen_decides_nothing);
  RUN_TEST(test_no_change_is_none);
  RUN_TEST(test_short_sessions_add_up);
  RUN_TEST(test_a_covered_camera_is_no_misfit);
  RUN_TEST(test_an_asked_calibration_shows_when_it_is_done);
  RUN_TEST(test_a_joint_filter_calibrates_no_segments);
  return UNITY_END();
}
