// The caller's storage: whatever it held before, and whatever bad data come in between, the same bits come out; nothing
// is written outside of it.
#include <memory>
#include <string>

#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

/// The whole stream, calibration at the end; with rubbish in between where asked.
void feed(segcal_t* device, Way way, bool rubbish) {
  for (std::size_t i = 0; i < stream().imu.size(); ++i) {
    TEST_ASSERT_GREATER_OR_EQUAL_INT(0, segcal_push_imu(device, &stream().imu[i]));
    if (i % 20 == 0) push_frame(device, stream().frames[i / 20], way);
    if (rubbish && i > 20 && i % 100 == 3) push_rubbish(device, stream().imu[i], stream().frames[i / 20]);
  }
  segcal_flush(device);
  segcal_background(device, 1);
}

/// All that a run tells, as text with every bit.
std::string answers(segcal_t* device) {
  std::string text;
  char line[160];
  const auto add = [&](const char* name, double value) {
    std::snprintf(line, sizeof line, "%s %a\n", name, value);
    text += line;
  };
  segcal_state_t state;
  if (segcal_get_state(device, &state) == SEGCAL_OK) {
    for (double v : state.p_GI) add("p", v);
    for (double v : state.b_g) add("b_g", v);
  }
  static segcal_result_t result;
  add("calibrate", segcal_calibrate(device));
  if (segcal_get_result(device, &result) != SEGCAL_OK) return text;
  for (int i = 0; i < result.n_parameters; ++i) {
    add(result.parameter[i].name, result.parameter[i].value);
    add("sigma", result.parameter[i].sigma);
  }
  add("chi2", result.chi2);
  add("segments", result.segments);
  for (int i = 0; i <= SEGCAL_MAX_SEGMENTS; ++i) {
    segcal_segment_t segment;
    if (segcal_get_segment(device, i, &segment) == SEGCAL_OK) add("A", segment.A);
  }
  return text;
}

std::string run(int fill, Way way, bool rubbish) {
  Storage storage(fill);
  segcal_t* device = create(&storage, SyntheticStream::config());
  feed(device, way, rubbish);
  return answers(device);
}

void check_same_answers(Way way) {
  const std::string clean = run(0, way, false);
  const Id id = Id().add("way", way == Way::tracks ? "tracks" : "keyframes");
  test::check_true(id, "nothing was calibrated", clean.find("segments") != std::string::npos);
  test::check_true(id.add("storage", "0xFF"), "another result", run(0xFF, way, false) == clean);
  test::check_true(id.add("storage", "0xA5"), "another result", run(0xA5, way, false) == clean);
  test::check_true(id.add("storage", "rubbish"), "refused data changed the result", run(0, way, true) == clean);
}

void test_storage_content_and_refused_data_change_nothing_with_keyframes() { check_same_answers(Way::keyframes); }
void test_storage_content_and_refused_data_change_nothing_with_tracks() { check_same_answers(Way::tracks); }

void test_nothing_is_written_behind_the_storage() {
  const std::size_t size = segcal_storage_bytes();
  std::vector<unsigned char> bytes(size + 4096, 0x5A);
  void* place = bytes.data();
  std::size_t space = bytes.size();
  TEST_ASSERT_NOT_NULL(std::align(SEGCAL_STORAGE_ALIGNMENT, size, place, space));
  segcal_t* device = nullptr;
  const segcal_config_t config = SyntheticStream::config();
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_create(&device, &config, place, size));
  feed(device, Way::keyframes, false);
  segcal_calibrate(device);
  const unsigned char* end = static_cast<unsigned char*>(place) + size;
  for (const unsigned char* p = end; p < bytes.data() + bytes.size(); ++p) TEST_ASSERT_EQUAL_HEX8(0x5A, *p);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_storage_content_and_refused_data_change_nothing_with_keyframes);
  RUN_TEST(test_storage_content_and_refused_data_change_nothing_with_tracks);
  RUN_TEST(test_nothing_is_written_behind_the_storage);
  return UNITY_END();
}
