// Data that must not harm: repeated tracks, stamps from another time, sensors with a FIFO, places far from the origin,
// counts below zero. Where the bad data carry nothing, the result is that of the good ones alone, bit by bit.
#include <limits>

#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

constexpr int kSeconds = 14;

segcal_counters_t counters_of(const segcal_t* device) {
  segcal_counters_t counters;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_counters(device, &counters));
  return counters;
}

/// How a stream is fed: each function may change what comes.
struct Feed {
  void (*frame)(SyntheticStream::Frame*) = [](SyntheticStream::Frame*) {};
  bool (*bad_sample)(int i, segcal_imu_t*) = [](int, segcal_imu_t*) { return false; };  ///< fed before sample i
  void (*change)(int i, segcal_imu_t*) = [](int, segcal_imu_t*) {};                     ///< of sample i
  int block = 1;  ///< samples come in blocks of so many, after the frames of their time
  Way way = Way::tracks;
};

/// Feeds samples [from, to) and their frames, with work in between.
void feed(segcal_t* device, const Feed& how, int from = 0, int to = 1 << 30) {
  const std::vector<segcal_imu_t>& imu = long_stream<kSeconds>().imu;
  if (to > int(imu.size())) to = int(imu.size());
  for (int i = from; i < to; i += how.block) {
    const int end = i + how.block < to ? i + how.block : to;
    const auto frames = [&] {
      for (int k = i; k < end; ++k) {
        if (k % 20 != 0) continue;
        SyntheticStream::Frame frame = long_stream<kSeconds>().frames[k / 20];
        how.frame(&frame);
        push_frame(device, frame, how.way);
      }
    };
    if (how.way == Way::tracks) frames();
    for (int k = i; k < end; ++k) {
      segcal_imu_t bad = imu[k];
      if (how.bad_sample(k, &bad)) segcal_push_imu(device, &bad);
      segcal_imu_t sample = imu[k];
      how.change(k, &sample);
      TEST_ASSERT_GREATER_OR_EQUAL_INT(0, segcal_push_imu(device, &sample));
      segcal_background(device, 3);
    }
    if (how.way == Way::keyframes) frames();
  }
}

std::uint64_t hash_of(segcal_t* device) {
  segcal_flush(device);
  segcal_calibrate(device);
  return segcal_result_hash(device);
}

std::uint64_t hash_of_stream(const Feed& how) {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  feed(device, how);
  return hash_of(device);
}

void repeat_points(SyntheticStream::Frame* frame, int copies) {
  const std::vector<segcal_point_t> once = frame->points;
  frame->points.clear();
  for (std::size_t i = 0; i < once.size() && frame->points.size() + copies <= SEGCAL_MAX_TRACKS; ++i) {
    for (int c = 0; c < copies; ++c) {
      frame->points.push_back(once[i]);
      frame->points.back().u += float(c);  // another place: taken twice, it would be another measurement
    }
  }
}

void keep_first(SyntheticStream::Frame* frame, std::size_t n) {
  if (frame->points.size() > n) frame->points.resize(n);
}

void test_a_track_twice_in_an_image_counts_once() {
  for (const Way way : {Way::tracks, Way::keyframes}) {
    Feed once, twice, often;
    once.way = twice.way = often.way = way;
    once.frame = [](SyntheticStream::Frame* f) { keep_first(f, SEGCAL_MAX_TRACKS / 5); };
    twice.frame = [](SyntheticStream::Frame* f) { keep_first(f, SEGCAL_MAX_TRACKS / 5), repeat_points(f, 2); };
    often.frame = [](SyntheticStream::Frame* f) { keep_first(f, SEGCAL_MAX_TRACKS / 5), repeat_points(f, 5); };
    const std::uint64_t expected = hash_of_stream(once);
    const Id id = Id().add("way", way == Way::tracks ? "tracks" : "keyframes");
    check_true(id.add("copies", 2), "another result", hash_of_stream(twice) == expected);
    check_true(id.add("copies", 5), "another result", hash_of_stream(often) == expected);
  }
}

void test_ids_that_are_used_again_are_survived() {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  Feed how;
  how.frame = [](SyntheticStream::Frame* f) {
    for (segcal_point_t& p : f->points) p.track_id %= 37;
  };
  feed(device, how);
  hash_of(device);
  TEST_ASSERT_GREATER_THAN_UINT(100, counters_of(device).points_repeated);
}

void test_one_stamp_from_another_time_costs_one_sample() {
  const std::uint64_t expected = hash_of_stream({});
  for (const std::int64_t away : {std::int64_t(1) << 45, -(std::int64_t(1) << 45), INT64_MAX, INT64_MIN}) {
    Storage storage(0xFF);
    segcal_t* device = create(&storage, SyntheticStream::config());
    static std::int64_t stamp;
    stamp = away == INT64_MAX || away == INT64_MIN ? away : long_stream<kSeconds>().imu[900].t_ns + away;
    Feed how;
    how.bad_sample = [](int i, segcal_imu_t* s) {
      s->t_ns = stamp;
      return i == 900;
    };
    feed(device, how);
    const Id id = Id().add("away_ns", away);
    check_true(id, "another result", hash_of(device) == expected);
    check_near(id, "imu_stamps_far", 1, counters_of(device).imu_stamps_far, 0);
  }
}

/// 10 hours forwards, backwards: the stream begins anew after 8 samples.
void test_a_clock_that_was_set_is_followed() {
  for (const std::int64_t by : {std::int64_t(36000000000000), -std::int64_t(36000000000000)}) {
    Storage storage(0xFF);
    segcal_t* device = create(&storage, SyntheticStream::config());
    feed(device, {}, 0, 1000);
    const std::uint32_t before = counters_of(device).frames_used;
    for (int i = 1000; i < 2400; ++i) {
      segcal_imu_t sample = long_stream<kSeconds>().imu[i];
      sample.t_ns += by;
      segcal_push_imu(device, &sample);
      if (i % 20 != 0) continue;
      const SyntheticStream::Frame& frame = long_stream<kSeconds>().frames[i / 20];
      segcal_push_tracks(device, frame.state.t_ns + by, frame.points.data(),
                         std::min(int(frame.points.size()), SEGCAL_MAX_TRACKS));
    }
    const segcal_counters_t after = counters_of(device);
    const Id id = Id().add("by_ns", by);
    check_near(id, "imu_stamps_far", 7, after.imu_stamps_far, 0);
    check_true(id, "the filter runs again", after.frames_used > before + 40);  // of 70 frames, 8 at most for the start
  }
}

/// An image from another time is refused, those after it are taken.
void test_one_image_from_another_time() {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  feed(device, {}, 0, 1000);
  const SyntheticStream::Frame& frame = long_stream<kSeconds>().frames[50];
  for (const std::int64_t stamp : {frame.state.t_ns + (std::int64_t(1) << 45), INT64_MAX, INT64_MIN}) {
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STAMP, segcal_push_tracks(device, stamp, frame.points.data(), 20));
  }
  TEST_ASSERT_EQUAL_UINT(3, counters_of(device).frame_stamps_far);
  const std::uint32_t used = counters_of(device).frames_used;
  feed(device, {}, 1000);
  TEST_ASSERT_GREATER_THAN_UINT(used + 60, counters_of(device).frames_used);
}

/// When it comes nothing tells that it is: no sample has come yet, or none of the new session.
void test_the_first_image_from_another_time() {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  const SyntheticStream::Frame& frame = long_stream<kSeconds>().frames[0];
  for (const int from : {0, 1000}) {
    const Id id = Id().add("from", from);
    const segcal_counters_t before = counters_of(device);
    if (from > 0) TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_new_session(device));
    segcal_push_tracks(device, frame.state.t_ns + (std::int64_t(1) << 45), frame.points.data(), 20);
    feed(device, {}, from, 1000 + from);
    const segcal_counters_t after = counters_of(device);
    check_near(id, "frame_stamps_far", 1, after.frame_stamps_far - before.frame_stamps_far, 0);
    check_near(id, "frame_stamps_back", 0, after.frame_stamps_back - before.frame_stamps_back, 0);
    check_true(id, "images are used", after.frames_used > before.frames_used + 30);  // of 50
  }
}

/// No chip has such a temperature: the sample's values count, its warmth does not.
void test_impossible_temperatures_change_nothing() {
  if (SEGCAL_MAX_EFFECT_ESTIMATES < 3) return;  // not in profile mcu
  segcal_config_t config = SyntheticStream::config();
  config.has_temperature = 1;
  config.estimate_effects = SEGCAL_EFFECT_GYRO_TEMPERATURE;
  std::uint64_t expected = 0;
  for (const float glitch : {30.f, 201.f, -3e38f, 4e20f, std::numeric_limits<float>::quiet_NaN()}) {
    Storage storage(0xFF);
    segcal_t* device = create(&storage, config);
    static float now;
    now = glitch;
    Feed how;
    how.change = [](int i, segcal_imu_t* s) { s->temperature = i % 100 == 50 ? now : 30; };
    feed(device, how);
    const std::uint64_t hash = hash_of(device);
    if (glitch == 30.f) expected = hash;
    check_true(Id().add("degC", glitch), "the result of 30 degC", hash == expected);
  }
}

/// Blocks of 250 ms: three images wait for the samples of the first.
void test_blocks_of_samples_give_the_same_result() {
  Feed blocks;
  blocks.block = 50;
  TEST_ASSERT_TRUE(hash_of_stream({}) == hash_of_stream(blocks));
}

/// A spike beyond full scale is bridged by its neighbours, not integrated.
void test_a_spike_beyond_full_scale_is_not_used() {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  Feed how;
  how.bad_sample = [](int i, segcal_imu_t* s) {
    s->accel[1] = 1e4f;
    s->t_ns -= 2000000;
    return i % 400 == 399;
  };
  feed(device, how);
  TEST_ASSERT_TRUE(hash_of(device) == hash_of_stream({}));
  TEST_ASSERT_EQUAL_UINT(int(kSeconds * 200) / 400, counters_of(device).imu_saturated);
}

segcal_counters_t counters_of_stream(const Feed& how) {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  feed(device, how);
  return counters_of(device);
}

/// Of the filter, from the first `samples`.
segcal_state_t state_after(const Feed& how, int samples) {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  feed(device, how, 0, samples);
  segcal_state_t state;
  std::memset(&state, 0, sizeof state);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_state(device, &state));
  return state;
}

/// `kWidth` readings from `kFirst` on are off.
template <int kFirst, int kWidth>
Feed spiked() {
  Feed how;
  how.change = [](int i, segcal_imu_t* s) { s->gyro[1] += i >= kFirst && i < kFirst + kWidth ? 5.0f : 0.0f; };
  return how;
}

/// At full scale the device leaves them out at once, when they come.
template <int kFirst, int kWidth>
Feed clipped() {
  Feed how;
  how.change = [](int i, segcal_imu_t* s) { s->accel[0] = i >= kFirst && i < kFirst + kWidth ? 1e4f : s->accel[0]; };
  return how;
}

template <int kFirst, int kWidth>
void check_bridged() {
  const segcal_counters_t counters = counters_of_stream(spiked<kFirst, kWidth>());
  TEST_ASSERT_EQUAL_UINT(kWidth, counters.imu_spikes);
  TEST_ASSERT_EQUAL_UINT(counters_of_stream({}).frames_used, counters.frames_used);
  const segcal_state_t bridged = state_after(spiked<kFirst, kWidth>(), 1100),
                       left_out = state_after(clipped<kFirst, kWidth>(), 1100);
  TEST_ASSERT_EQUAL_MEMORY(&left_out, &bridged, sizeof bridged);
}

template <int kFirst, int kWidth>
void check_started_again() {
  const segcal_counters_t counters = counters_of_stream(spiked<kFirst, kWidth>());
  TEST_ASSERT_EQUAL_UINT(kWidth, counters.imu_spikes);
  TEST_ASSERT_LESS_THAN_UINT(counters_of_stream({}).frames_used, counters.frames_used);
  TEST_ASSERT_EQUAL_UINT(0, counters.imu_gaps);
}

/// Readings that stand alone, one or two, are known as such when the next one has come. They are taken out again, and
/// the filter goes on; if a frame has used one (frames come with every twentieth), the filter starts again.
void test_a_spike_is_taken_out_of_the_stream() {
  check_bridged<1007, 1>();
  check_bridged<1007, 2>();
  check_bridged<1001, 2>();
  check_started_again<1000, 1>();
  check_started_again<999, 2>();
  check_started_again<1000, 2>();
}

/// Largest difference of two results in units of the first one's sigmas.
double difference_in_sigmas(const segcal_t* a, const segcal_t* b) {
  segcal_result_t x, y;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(a, &x));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(b, &y));
  double largest = 0;
  for (int i = 0; i < x.n_parameters; ++i) {
    largest = std::fmax(largest, std::fabs(x.parameter[i].value - y.parameter[i].value) / x.parameter[i].sigma);
  }
  return largest;
}

/// 10 000 km away, float alone would resolve 1 m. What is left is the rounding of places within a segment.
void test_keyframes_far_from_the_origin_give_the_same_result() {
  Feed how;
  how.way = Way::keyframes;
  Storage near_storage(0), far_storage(0);
  segcal_t* near_device = create(&near_storage, SyntheticStream::config());
  segcal_t* far_device = create(&far_storage, SyntheticStream::config());
  feed(near_device, how);
  how.frame = [](SyntheticStream::Frame* f) {
    f->state.p_GI[0] += 7e6;
    f->state.p_GI[1] -= 7e6;
  };
  feed(far_device, how);
  hash_of(near_device), hash_of(far_device);
  check_between(Id(), "difference in sigmas", 0, difference_in_sigmas(near_device, far_device), 0.02);
  segcal_state_t state;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_state(far_device, &state));
  check_near(Id().add("place", "far"), "p_GI.x", long_stream<kSeconds>().frames.back().state.p_GI[0] + 7e6,
             state.p_GI[0], 1e-4);
}

void test_counts_below_zero_are_refused() {
  Storage storage(0);
  segcal_t* device = create(&storage, SyntheticStream::config());
  feed(device, {});
  hash_of(device);
  static char out[1 << 20];
  const auto as = [](auto* p) { return reinterpret_cast<decltype(p)>(out); };
  int slot = 0;
  segcal_segment_t segment;
  while (slot <= SEGCAL_MAX_SEGMENTS && segcal_get_segment(device, slot, &segment) != SEGCAL_OK) ++slot;
  const int codes[] = {segcal_get_keyframes(device, slot, as((segcal_state_t*)nullptr), -3),
                       segcal_get_landmarks(device, slot, as((segcal_landmark_t*)nullptr), -3),
                       segcal_get_points(device, slot, as((segcal_measured_point_t*)nullptr), -3),
                       segcal_get_samples(device, slot, as((segcal_imu_t*)nullptr), -3),
                       segcal_get_point_residuals(device, slot, as((segcal_point_residual_t*)nullptr), -3),
                       segcal_get_imu_residuals(device, slot, as((segcal_imu_residual_t*)nullptr), -3),
                       segcal_get_segment_sigmas(device, as((double*)nullptr), -3),
                       segcal_get_segment_directions(device, as((segcal_direction_t*)nullptr), -3),
                       segcal_get_effect_scores(device, as((segcal_effect_score_t*)nullptr), -3),
                       segcal_get_terms(device, as((segcal_term_t*)nullptr), as((double*)nullptr), -3)};
  for (std::size_t i = 0; i < sizeof codes / sizeof *codes; ++i)
    check_near(Id().add("getter", i), "code", SEGCAL_ERROR_SIZE, codes[i], 0);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc - 1, argv + 1);
  UNITY_BEGIN();
  RUN_TEST(test_a_track_twice_in_an_image_counts_once);
  RUN_TEST(test_ids_that_are_used_again_are_survived);
  RUN_TEST(test_one_stamp_from_another_time_costs_one_sample);
  RUN_TEST(test_a_clock_that_was_set_is_followed);
  RUN_TEST(test_one_image_from_another_time);
  RUN_TEST(test_the_first_image_from_another_time);
  RUN_TEST(test_impossible_temperatures_change_nothing);
  RUN_TEST(test_blocks_of_samples_give_the_same_result);
  RUN_TEST(test_a_spike_beyond_full_scale_is_not_used);
  RUN_TEST(test_a_spike_is_taken_out_of_the_stream);
  RUN_TEST(test_keyframes_far_from_the_origin_give_the_same_result);
  RUN_TEST(test_counts_below_zero_are_refused);
  return UNITY_END();
}
