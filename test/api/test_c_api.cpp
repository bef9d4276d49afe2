// Error codes of the C API: bad storage, configuration, pointers, data, and calls at the wrong time.
#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

void test_refused_data_are_counted() {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  for (int i = 0; i <= 40; ++i) segcal_push_imu(device, &stream().imu[i]);
  push_frame(device, stream().frames[1], Way::tracks);
  push_rubbish(device, stream().imu[40], stream().frames[1]);
  segcal_counters_t counters;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_counters(device, &counters));
  TEST_ASSERT_EQUAL_UINT(2, counters.imu_stamps_back);
  TEST_ASSERT_EQUAL_UINT(4, counters.imu_not_finite);
  TEST_ASSERT_EQUAL_UINT(1, counters.frame_stamps_back);
}

void test_points_that_are_no_numbers_are_dropped() {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  for (int i = 0; i <= 20; ++i) segcal_push_imu(device, &stream().imu[i]);
  SyntheticStream::Frame frame = stream().frames[1];
  frame.points[3].u = std::numeric_limits<float>::quiet_NaN();
  frame.points[5].v = std::numeric_limits<float>::infinity();
  push_frame(device, frame, Way::tracks);
  segcal_counters_t counters;
  segcal_get_counters(device, &counters);
  TEST_ASSERT_EQUAL_UINT(2, counters.points_not_finite);
}

void test_storage_is_checked() {
  const segcal_config_t config = SyntheticStream::config();
  Storage storage(0), shifted(0, 8), odd(0, 1);
  segcal_t* device = reinterpret_cast<segcal_t*>(&storage);
  const std::size_t size = segcal_storage_bytes();
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_create(&device, &config, storage.data, size - 1));
  TEST_ASSERT_NULL(device);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_create(&device, &config, storage.data, 0));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_ALIGNMENT, segcal_create(&device, &config, shifted.data, size));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_ALIGNMENT, segcal_create(&device, &config, odd.data, size));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_create(&device, &config, nullptr, size));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_create(&device, nullptr, storage.data, size));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_create(nullptr, &config, storage.data, size));
  TEST_ASSERT_TRUE(size <= SEGCAL_STORAGE_BYTES);
}

/// One wrong value in an otherwise good configuration.
void check_refused(const char* what, void (*spoil)(segcal_config_t*)) {
  segcal_config_t config = SyntheticStream::config();
  spoil(&config);
  Storage storage(0);
  segcal_t* device = nullptr;
  const int code = segcal_create(&device, &config, storage.data, segcal_storage_bytes());
  test::check_near(Id().add("config", what), "code", SEGCAL_ERROR_CONFIG, code, 0);
  TEST_ASSERT_NULL(device);
}

void test_configuration_is_checked() {
  check_refused("cameras", [](segcal_config_t* c) { c->n_cameras = SEGCAL_MAX_CAMERAS + 1; });
  check_refused("model", [](segcal_config_t* c) { c->camera[0].model = 3; });
  check_refused("focal", [](segcal_config_t* c) { c->camera[0].intrinsics[0] = 0; });
  check_refused("focal_nan", [](segcal_config_t* c) { c->camera[0].intrinsics[1] = std::nan(""); });
  check_refused("quaternion", [](segcal_config_t* c) { c->camera[0].q_CI[0] = 3; });
  check_refused("w", [](segcal_config_t* c) { c->camera[0].distortion[0] = 3; });
  check_refused("scale", [](segcal_config_t* c) { c->imu.gyro_scale[2] = -1; });
  check_refused("noise", [](segcal_config_t* c) { c->gyro_noise_density = -1; });
  check_refused("pixel", [](segcal_config_t* c) { c->pixel_sigma = std::nan(""); });
  check_refused("segments", [](segcal_config_t* c) { c->keep_segments = SEGCAL_MAX_SEGMENTS + 1; });
  check_refused("metric", [](segcal_config_t* c) { c->metric = 9; });
  check_refused("strategy", [](segcal_config_t* c) { c->strategy = -1; });
  check_refused("prior", [](segcal_config_t* c) { c->prior_sigma[4] = -0.1; });
}

/// Every call on a handle that stands for no device.
void check_no_device(segcal_t* device) {
  segcal_imu_t sample = stream().imu[0];
  segcal_state_t state = stream().frames[0].state;
  segcal_camera_t camera;
  segcal_imu_calibration_t imu;
  segcal_counters_t counters;
  segcal_segment_t segment;
  segcal_direction_t direction;
  static segcal_result_t result;
  const int codes[] = {segcal_push_imu(device, &sample), segcal_push_tracks(device, 0, nullptr, 0),
                       segcal_push_keyframe(device, &state, nullptr, 0), segcal_background(device, 1), segcal_flush(device),
                       segcal_new_session(device), segcal_calibrate(device), segcal_get_state(device, &state),
                       segcal_get_camera(device, 0, &camera), segcal_get_imu_calibration(device, &imu),
                       segcal_get_result(device, &result), segcal_get_direction(device, 0, &direction),
                       segcal_get_segment(device, -1, &segment), segcal_get_segment_directions(device, &direction, 1),
                       segcal_get_counters(device, &counters)};
  for (std::size_t i = 0; i < sizeof codes / sizeof codes[0]; ++i) {
    test::check_between(Id().add("call", i).add("handle", device ? "zeroes" : "null"), "code", -100, codes[i], -1);
  }
}

void test_calls_without_a_device() {
  check_no_device(nullptr);
  Storage zeroes(0);
  check_no_device(reinterpret_cast<segcal_t*>(zeroes.data));
}

void test_null_pointers() {
  Storage storage(0);
  segcal_t* device = create(&storage, SyntheticStream::config());
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_push_imu(device, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_push_tracks(device, 0, nullptr, 5));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_push_keyframe(device, nullptr, nullptr, 0));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_state(device, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_camera(device, 0, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_imu_calibration(device, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_result(device, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_direction(device, 0, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_segment(device, 0, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_segment_directions(device, nullptr, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_segment_sigmas(device, nullptr, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_counters(device, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_point_residuals(device, 0, nullptr, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_imu_residuals(device, 0, nullptr, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_get_keyframes(device, 0, nullptr, 1));
}

void test_calls_too_early() {
  Storage storage(0xFF);
  segcal_t* device = create(&storage, SyntheticStream::config());
  segcal_state_t state;
  static segcal_result_t result;
  segcal_segment_t segment;
  segcal_camera_t camera;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_state(device, &state));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_result(device, &result));
  for (int index : {-2, -1, 0, SEGCAL_MAX_SEGMENTS, SEGCAL_MAX_SEGMENTS + 1}) {
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_segment(device, index, &segment));
  }
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CAMERA, segcal_get_camera(device, 1, &camera));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CAMERA, segcal_get_camera(device, -1, &camera));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_flush(device));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_new_session(device));
  TEST_ASSERT_EQUAL_INT(0, segcal_background(device, 3));
}

void test_configuration_comes_back() {
  Storage storage(0xFF);
  const segcal_config_t config = SyntheticStream::config();
  segcal_t* device = create(&storage, config);
  segcal_camera_t camera;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_camera(device, 0, &camera));
  const Id id = Id().add("check", "camera");
  for (int i = 0; i < 4; ++i) {
    test::check_near(id.add("entry", i), "intrinsics", config.camera[0].intrinsics[i], camera.intrinsics[i], 1e-4);
  }
  // A quaternion and its negative are the same rotation.
  double dot = 0;
  for (int i = 0; i < 4; ++i) dot += config.camera[0].q_CI[i] * camera.q_CI[i];
  test::check_near(id, "q_CI", 1, std::fabs(dot), 1e-6);
  segcal_imu_calibration_t imu;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_imu_calibration(device, &imu));
  for (double scale : imu.gyro_scale) test::check_near(id, "a zero scale means one", 1, scale, 0);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_storage_is_checked);
  RUN_TEST(test_configuration_is_checked);
  RUN_TEST(test_configuration_comes_back);
  RUN_TEST(test_calls_without_a_device);
  RUN_TEST(test_null_pointers);
  RUN_TEST(test_calls_too_early);
  RUN_TEST(test_refused_data_are_counted);
  RUN_TEST(test_points_that_are_no_numbers_are_dropped);
  return UNITY_END();
}
