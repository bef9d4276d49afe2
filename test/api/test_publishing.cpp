// Results are published whole, whoever asks and whenever: getters
// between any two slices change no bit and see no half-done work.
#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

#ifdef PUBLISHING_SHORT
constexpr double kSeconds = 15;
const std::vector<int> kSlices = {3};
#else
constexpr double kSeconds = 30;
const std::vector<int> kSlices = {1, 3, 20, 1000000};
#endif
constexpr std::int64_t kLate = 4000000;  // ns, of the images' stamps
const SyntheticStream& long_stream() {
  static const SyntheticStream instance(11, kSeconds);
  return instance;
}

/// An image whose stamp is late.
void push_late(segcal_t* device, SyntheticStream::Frame frame) {
  frame.state.t_ns += kLate;
  push_frame(device, frame, Way::tracks);
}

segcal_config_t config() {
  segcal_config_t c = SyntheticStream::config();
  c.estimate_effects = SEGCAL_EFFECT_TIME_OFFSET;
  if (SEGCAL_MAX_EFFECT_COLUMNS >= 3) c.watch_effects = SEGCAL_EFFECT_ROLLING_SHUTTER;
  return c;
}

/// Everything that can be asked.
void ask_everything(segcal_t* device) {
  static char out[1 << 20];
  const auto as = [](auto* p) { return reinterpret_cast<decltype(p)>(out); };
  const int n = 4000;
  segcal_get_effect_scores(device, as((segcal_effect_score_t*)nullptr), SEGCAL_EFFECTS);
  segcal_get_filter_calibration(device, as((segcal_result_t*)nullptr));
  segcal_get_counters(device, as((segcal_counters_t*)nullptr));
  segcal_get_state(device, as((segcal_state_t*)nullptr));
  segcal_get_camera(device, 0, as((segcal_camera_t*)nullptr));
  segcal_get_imu_calibration(device, as((segcal_imu_calibration_t*)nullptr));
  segcal_get_result(device, as((segcal_result_t*)nullptr));
  segcal_get_posterior(device, as((double*)nullptr), as((double*)nullptr) + SEGCAL_MAX_PARAMETERS,
                       SEGCAL_MAX_PARAMETERS * SEGCAL_MAX_PARAMETERS);
  segcal_get_epoch(device, 0, as((segcal_epoch_t*)nullptr));
  segcal_get_change(device, 0, as((segcal_change_t*)nullptr));
  segcal_get_history(device, 0, as((segcal_epoch_t*)nullptr));
  segcal_get_course(device, as((segcal_course_t*)nullptr));
  segcal_get_direction(device, 0, as((segcal_direction_t*)nullptr));
  segcal_get_health(device);
  segcal_get_model(device, as((segcal_model_t*)nullptr));
  segcal_get_terms(device, as((segcal_term_t*)nullptr), as((double*)nullptr) + n, 40);
  segcal_progress(device, as((segcal_progress_t*)nullptr));
  segcal_get_segment_directions(device, as((segcal_direction_t*)nullptr), 40);
  segcal_get_segment_sigmas(device, as((double*)nullptr), SEGCAL_MAX_PARAMETERS);
  for (int slot = -1; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
    segcal_get_segment(device, slot, as((segcal_segment_t*)nullptr));
    segcal_get_keyframes(device, slot, as((segcal_state_t*)nullptr), 40);
    segcal_get_landmarks(device, slot, as((segcal_landmark_t*)nullptr), 200);
    segcal_get_point_residuals(device, slot, as((segcal_point_residual_t*)nullptr), n);
    segcal_get_imu_residuals(device, slot, as((segcal_imu_residual_t*)nullptr), n);
    segcal_get_points(device, slot, as((segcal_measured_point_t*)nullptr), n);
    segcal_get_samples(device, slot, as((segcal_imu_t*)nullptr), n);
    segcal_get_link(device, slot, as((segcal_link_t*)nullptr));
  }
  static std::uint8_t use[SEGCAL_MAX_SEGMENTS + 1];
  for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot)
    use[slot] = segcal_get_segment(device, slot, as((segcal_segment_t*)nullptr)) == SEGCAL_OK;
  std::int32_t a, b, c;
  segcal_linearise(device, use, nullptr, 0, as((double*)nullptr), sizeof out / sizeof(double), &a, &b, &c);
  segcal_result_hash(device);
}

/// The result as it is shown must be one that was published: whole.
void check_whole(const segcal_t* device, const Id& id) {
  segcal_result_t r;
  if (segcal_get_result(device, &r) != SEGCAL_OK) return;
  check_between(id, "dof", 1, r.dof, 1e9);
  check_between(id, "image points", 1, r.image_points, 1e9);
  check_between(id, "chi2/dof", 0.1, r.chi2 / r.dof, 10);
}

struct Run {
  std::uint64_t at_the_end, on_the_way;  ///< hashes; the second one over those at each half second
  std::uint32_t calibrations;
};

/// `due`: what is late is done at once (segcal_work_when_due), so that the number of slices changes nothing.
Run run(int slices, bool ask, const Id& id, bool due = true) {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, config());
  segcal_work_when_due(device, due);
  Run out{0, 14695981039346656037ull, 0};
  for (std::size_t i = 0; i < long_stream().imu.size(); ++i) {
    segcal_push_imu(device, &long_stream().imu[i]);
    if (i % 20 == 0) {
      const SyntheticStream::Frame& frame = long_stream().frames[i / 20];
      push_late(device, frame);
    }
    for (int left = slices; left > 0; left -= 3) {
      const int pending = segcal_background(device, left < 3 ? left : 3);
      if (ask && i % 7 == 0) ask_everything(device);
      check_whole(device, id.add("sample", i));
      if (!pending) break;
    }
    if (i % 100 == 99) out.on_the_way = (out.on_the_way ^ segcal_result_hash(device)) * 1099511628211ull;
  }
  segcal_flush(device);
  segcal_calibrate(device);
  segcal_counters_t counters;
  segcal_get_counters(device, &counters);
  out.calibrations = counters.calibrations;
  out.at_the_end = segcal_result_hash(device);
  return out;
}

void test_getters_and_slices_change_no_bit() {
  const Run expected = run(0, false, Id().add("slices", 0));
  TEST_ASSERT_GREATER_OR_EQUAL_UINT(2, expected.calibrations);  // one of its own, and the one at the end
  for (const int slices : kSlices) {
    for (const bool ask : {false, true}) {
      const Id id = Id().add("slices", slices).add("ask", ask);
      const Run now = run(slices, ask, id);
      check_true(id, "another result at the end", now.at_the_end == expected.at_the_end);
      check_true(id, "another hash on the way", now.on_the_way == expected.on_the_way);
    }
  }
}

/// Where late work is lost, as on a device with deadlines, results depend on the slices, but not on who asks.
void test_getters_change_no_bit_with_deadlines() {
  for (const int slices : {1, 8}) {
    const Id id = Id().add("slices", slices);
    const Run silent = run(slices, false, id, false), asked = run(slices, true, id, false);
    check_true(id, "another result at the end", asked.at_the_end == silent.at_the_end);
    check_true(id, "another hash on the way", asked.on_the_way == silent.on_the_way);
  }
}

/// Of all kept segments.
std::vector<segcal_point_residual_t> point_residuals(const segcal_t* device) {
  std::vector<segcal_point_residual_t> all, of_one(4000);
  for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
    const int n = segcal_get_point_residuals(device, slot, of_one.data(), 4000);
    if (n > 0) all.insert(all.end(), of_one.begin(), of_one.begin() + n);
  }
  return all;
}

/// Residuals are those at the published calibration, or at the start, also after other rows were looked at.
void test_residuals_do_not_follow_what_was_looked_at() {
  Storage storage(0xFF);
  segcal_config_t c = SyntheticStream::config();
  c.keep_segments = SEGCAL_MAX_SEGMENTS;  // more than there will be: no calibration
  segcal_t* device = create(&storage, c);
  segcal_work_when_due(device, 1);
  for (std::size_t i = 0; i < 14 * 200; ++i) {
    segcal_push_imu(device, &long_stream().imu[i]);
    if (i % 20 == 0) push_frame(device, long_stream().frames[i / 20], Way::tracks);
  }
  segcal_flush(device);
  std::uint8_t use[SEGCAL_MAX_SEGMENTS + 1] = {};
  segcal_segment_t segment;
  for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
    use[slot] = segcal_get_segment(device, slot, &segment) == SEGCAL_OK;
  }
  const std::vector<segcal_point_residual_t> before = point_residuals(device);
  std::vector<double> triangle(10000);
  std::int32_t n_theta, n_terms, dof;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK,
                        segcal_linearise(device, use, nullptr, 0, triangle.data(), 10000, &n_theta, &n_terms, &dof));
  const std::vector<segcal_point_residual_t> after = point_residuals(device);
  TEST_ASSERT_GREATER_THAN_UINT(100, before.size());
  TEST_ASSERT_EQUAL_UINT(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    TEST_ASSERT_TRUE(before[i].u == after[i].u && before[i].v == after[i].v);
  }
}

/// All keyframes of a segment stand at their image's stamp plus one shift, also where a calibration with another time
/// offset took effect while the stream went on; and each segment holds the samples since the one before.
[[maybe_unused]] void test_a_new_time_offset_begins_with_a_segment() {
  Storage storage(0xFF);
  segcal_config_t c = config();
  c.strategy = SEGCAL_MULTI_SESSION;
  segcal_t* device = create(&storage, c);
  int shifted = 0, joined = 0;
  std::int64_t newest = 0;
  for (std::size_t i = 0; i < long_stream().imu.size(); ++i) {
    segcal_push_imu(device, &long_stream().imu[i]);
    segcal_background(device, 1000000);
    if (i % 20 == 0) {
      const SyntheticStream::Frame& frame = long_stream().frames[i / 20];
      push_late(device, frame);
    }
    segcal_segment_t segment;
    for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
      segcal_state_t keyframe[SEGCAL_MAX_KEYFRAMES];
      if (segcal_get_segment(device, slot, &segment) != SEGCAL_OK || segment.start_ns <= newest) continue;
      const int n = segcal_get_keyframes(device, slot, keyframe, SEGCAL_MAX_KEYFRAMES);
      if (n <= 0) continue;
      newest = segment.start_ns;
      segcal_link_t link;
      if (segment.serial > 1 && segcal_get_link(device, slot, &link) == SEGCAL_OK) {
        check_near(Id().add("serial", segment.serial), "samples since the last keyframe of the segment before, ns",
                   double(keyframe[1].t_ns - keyframe[0].t_ns), double(link.lead_ns), kLate);
        ++joined;
      }
      const auto shift = [](const segcal_state_t& k) {
        return (k.t_ns - kLate - long_stream().frames[0].state.t_ns + 50000000) % 100000000 - 50000000;
      };
      for (int k = 1; k < n; ++k) {
        check_near(Id().add("serial", segment.serial).add("keyframe", k), "shift, ns", double(shift(keyframe[0])),
                   double(shift(keyframe[k])), 1000);
      }
      shifted += shift(keyframe[0]) < -kLate / 2 ? 1 : 0;
    }
  }
  TEST_ASSERT_GREATER_OR_EQUAL_INT(1, shifted);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(2, joined);  // the fourth since the release: the first has no link, nor has a gap's
}

void test_other_capacities_are_refused_by_name() {
  Storage storage(0);
  const segcal_config_t c = config();
  std::uint32_t capacities[SEGCAL_N_CAPACITIES] = SEGCAL_CAPACITIES;
  char line[100], expected[100];
  TEST_ASSERT_EQUAL_INT(0, segcal_explain_capacities(capacities, line, sizeof line));
  TEST_ASSERT_EQUAL_STRING("", line);
  for (int i = 0; i < SEGCAL_N_CAPACITIES; ++i) {
    ++capacities[i];
    segcal_t* device = nullptr;
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CAPACITY,
                          segcal_create_for(&device, &c, storage.data, segcal_storage_bytes(), capacities));
    TEST_ASSERT_NULL(device);
    TEST_ASSERT_EQUAL_INT(1, segcal_explain_capacities(capacities, line, sizeof line));
    --capacities[i];
  }
  ++capacities[0];
  segcal_explain_capacities(capacities, line, sizeof line);
  std::snprintf(expected, sizeof expected, "SEGCAL_MAX_CAMERAS: the program has %d, the library %d",
                SEGCAL_MAX_CAMERAS + 1, SEGCAL_MAX_CAMERAS);
  TEST_ASSERT_EQUAL_STRING(expected, line);
  char small[8];
  segcal_explain_capacities(capacities, small, sizeof small);
  TEST_ASSERT_EQUAL_STRING("SEGCAL_", small);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc - 1, argv + 1);
  UNITY_BEGIN();
  RUN_TEST(test_getters_and_slices_change_no_bit);
  RUN_TEST(test_getters_change_no_bit_with_deadlines);
  RUN_TEST(test_residuals_do_not_follow_what_was_looked_at);
#ifndef PUBLISHING_SHORT  // too short for a second calibration
  RUN_TEST(test_a_new_time_offset_begins_with_a_segment);
#endif
  RUN_TEST(test_other_capacities_are_refused_by_name);
  return UNITY_END();
}
