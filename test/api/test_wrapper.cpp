// segcal.hpp and lookup.h: the same bits as the C API, a sentence for each code, parameters by name.
#include <segcal/segcal.hpp>
#include <set>
#include <string>

#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

void test_the_wrapper_is_the_api() {
  static segcal_cpp::Device wrapped(SyntheticStream::config());
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, wrapped.error());
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  wrapped.work_when_due(true);
  for (std::size_t i = 0; i < stream().imu.size(); ++i) {
    TEST_ASSERT_EQUAL_INT(segcal_push_imu(device, &stream().imu[i]), wrapped.push(stream().imu[i]));
    if (i % 20 != 0) continue;
    const SyntheticStream::Frame& frame = stream().frames[i / 20];
    const int n = std::min(static_cast<int>(frame.points.size()), SEGCAL_MAX_TRACKS);
    TEST_ASSERT_EQUAL_INT(segcal_push_tracks(device, frame.state.t_ns, frame.points.data(), n),
                          wrapped.push_tracks(frame.state.t_ns, frame.points.data(), n));
    wrapped.background(5);
  }
  segcal_flush(device);
  while (wrapped.flush_slices(7) == 1) {
  }
  TEST_ASSERT_EQUAL_INT(segcal_calibrate(device), wrapped.calibrate());
  TEST_ASSERT_TRUE(segcal_result_hash(device) == wrapped.result_hash());
  static segcal_result_t a, b;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(device, &a));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, wrapped.get(&b));
  TEST_ASSERT_EQUAL_MEMORY(a.parameter, b.parameter, sizeof *a.parameter * static_cast<std::size_t>(a.n_parameters));
  for (int i = 0; i < b.n_parameters; ++i)
    TEST_ASSERT_EQUAL_PTR(&b.parameter[i], segcal_find_parameter(&b, b.parameter[i].name));
  for (const char* name : {"", "cam0", "cam0.fx2", "cam0.f", "CAM0.FX"})
    TEST_ASSERT_NULL(segcal_find_parameter(&b, name));
}

void test_a_refused_configuration_is_no_device() {
  segcal_config_t config = SyntheticStream::config();
  config.camera[0].intrinsics[0] = -1;
  static segcal_cpp::Device device(config);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CONFIG, device.error());
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, device.background(1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, device.push(stream().imu[0]));
}

/// From SEGCAL_ERROR_VERSION to SEGCAL_EMPTY each has a sentence of its own, and no number beyond has one.
void test_each_code_has_a_sentence() {
  std::set<std::string> sentences;
  for (int code = SEGCAL_ERROR_VERSION; code <= SEGCAL_EMPTY; ++code) {
    check_true(Id().add("code", code), "unknown", std::string(segcal_code_words(code)) != "unknown");
    sentences.insert(segcal_code_words(code));
  }
  TEST_ASSERT_EQUAL_UINT(SEGCAL_EMPTY - SEGCAL_ERROR_VERSION + 1, sentences.size());
  TEST_ASSERT_EQUAL_STRING("unknown", segcal_code_words(SEGCAL_ERROR_VERSION - 1));
  TEST_ASSERT_EQUAL_STRING("unknown", segcal_code_words(SEGCAL_EMPTY + 1));
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc - 1, argv + 1);
  UNITY_BEGIN();
  RUN_TEST(test_the_wrapper_is_the_api);
  RUN_TEST(test_a_refused_configuration_is_no_device);
  RUN_TEST(test_each_code_has_a_sentence);
  return UNITY_END();
}
