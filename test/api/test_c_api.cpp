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
  // Numbers that double holds and float does not.
  check_refused("focal_huge", [](segcal_config_t* c) { c->camera[0].intrinsics[0] = 1e300; });
  check_refused("place_huge", [](segcal_config_t* c) { c->camera[0].p_CI[1] = -1e300; });
  check_refused("sigma_ref_tiny", [](segcal_config_t* c) { c->sigma_ref[3] = 1e-50; });
  check_refused("prior_tiny", [](segcal_config_t* c) { c->prior_sigma[3] = 1e-50; });
  check_refused("noise_tiny", [](segcal_config_t* c) { c->accel_noise_density = 1e-50; });
  check_refused("misalignment", [](segcal_config_t* c) { c->imu.accel_misalignment[0] = 1e200; });
}

/// True if a device takes the configuration.
bool taken(const segcal_config_t& config) {
  static Storage storage(0);
  segcal_t* device = nullptr;
  return segcal_create(&device, &config, storage.data, segcal_storage_bytes()) == SEGCAL_OK;
}

/// A number's limits: taken at both, refused a thousandth beyond.
void check_range(const char* what, double segcal_config_t::*field, double least, double most) {
  const double inf = std::numeric_limits<double>::infinity();
  for (double value : {least, 0.5 * (least + most), most}) {
    segcal_config_t config = SyntheticStream::config();
    config.*field = value;
    test::check_true(Id().add("config", what).add("value", value), "refused", taken(config));
  }
  for (double value : {least - 1e-3 - 1e-3 * std::fabs(least), most + 1e-3 + 1e-3 * most, std::nan(""), inf, -inf}) {
    segcal_config_t config = SyntheticStream::config();
    config.*field = value;
    test::check_true(Id().add("config", what).add("value", value), "taken", !taken(config));
  }
}

/// Zero stands for the default, so that it is in every range.
void test_ranges_of_numbers() {
  check_range("imu_rate_hz", &segcal_config_t::imu_rate_hz, 0, 20000);
  check_range("gyro_noise_density", &segcal_config_t::gyro_noise_density, 0, 1);
  check_range("gyro_random_walk", &segcal_config_t::gyro_random_walk, 0, 1);
  check_range("accel_noise_density", &segcal_config_t::accel_noise_density, 0, 10);
  check_range("accel_random_walk", &segcal_config_t::accel_random_walk, 0, 10);
  check_range("gyro_range", &segcal_config_t::gyro_range, 0, 1e4);
  check_range("accel_range", &segcal_config_t::accel_range, 0, 1e5);
  check_range("pixel_sigma", &segcal_config_t::pixel_sigma, 0, 100);
  check_range("gravity", &segcal_config_t::gravity, 0, 100);
  check_range("frame_interval_s", &segcal_config_t::frame_interval_s, 0, 2);
  check_range("segment_s", &segcal_config_t::segment_s, 0, 60);
  check_range("least_segment_s", &segcal_config_t::least_segment_s, 0, 2);  // segment_s
  check_range("least_gain_nats", &segcal_config_t::least_gain_nats, 0, 1e6);
  check_range("filter_share", &segcal_config_t::filter_share, 0, 1);
  check_range("trigger_fraction", &segcal_config_t::trigger_fraction, 0, 0.9999);
  check_range("outdated_level", &segcal_config_t::outdated_level, 0, 0.1);
}

void test_ranges_of_the_others() {
  segcal_config_t config = SyntheticStream::config();
  config.trigger_fraction = config.outdated_level = -1;  // never
  TEST_ASSERT_TRUE(taken(config));
  config = SyntheticStream::config();
  config.most_segment_s = 60;
  TEST_ASSERT_TRUE(taken(config));
  config.most_segment_s = 1.9;  // below segment_s
  TEST_ASSERT_FALSE(taken(config));
  for (int i = 0; i < 14 + 11; ++i) {
    for (double* sigma : {&config.prior_sigma[i], &config.sigma_ref[i], &config.trigger_sigma[i]}) {
      for (double value : {-1e-3, 1.1e6, std::nan("")}) {
        config = SyntheticStream::config();
        *sigma = value;
        test::check_true(Id().add("entry", i).add("value", value), "a sigma is taken", !taken(config));
      }
    }
  }
}

void test_ranges_of_choices() {
  const auto check = [](const char* what, std::int32_t segcal_config_t::*field, int least, int most) {
    for (int value = least - 2; value <= most + 2; ++value) {
      segcal_config_t config = SyntheticStream::config();
      config.*field = value;
      test::check_true(Id().add("config", what).add("value", value), "taken or refused",
                       taken(config) == (value >= least && value <= most));
    }
  };
  check("n_cameras", &segcal_config_t::n_cameras, 0, 1);  // two need the second one's focal length
  check("keep_segments", &segcal_config_t::keep_segments, 0, SEGCAL_MAX_SEGMENTS);
  check("metric", &segcal_config_t::metric, SEGCAL_METRIC_A, SEGCAL_METRIC_SET_D);
  check("strategy", &segcal_config_t::strategy, SEGCAL_SINGLE_SESSION, SEGCAL_MULTI_SESSION);
}

void test_ranges_of_a_camera() {
  segcal_config_t config = SyntheticStream::config();
  segcal_camera_t& camera = config.camera[0];
  double* const numbers[] = {&camera.p_CI[0],       &camera.p_CI[2],       &camera.intrinsics[0],
                             &camera.intrinsics[3], &camera.distortion[0], &camera.q_CI[2]};
  for (double* number : numbers) {
    for (double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
      config = SyntheticStream::config();
      *number = value;
      test::check_true(Id().add("byte", reinterpret_cast<char*>(number) - reinterpret_cast<char*>(&config)),
                       "not a number is taken", !taken(config));
    }
  }
  config = SyntheticStream::config();
  camera.distortion[0] = 2.5;
  TEST_ASSERT_TRUE(taken(config));
  camera.distortion[0] = 2.51;
  TEST_ASSERT_FALSE(taken(config));
  camera.distortion[0] = -0.01;
  TEST_ASSERT_FALSE(taken(config));
  camera.model = SEGCAL_RADTAN;  // there the same number is any coefficient
  TEST_ASSERT_TRUE(taken(config));
  for (double scale : {0.49, 2.01, std::nan("")}) {
    for (int i = 0; i < 3; ++i) {
      config = SyntheticStream::config();
      (i == 0   ? config.imu.gyro_scale[0]
       : i == 1 ? config.imu.accel_scale[2]
                : config.imu.accel_misalignment[1]) = scale;
      test::check_true(Id().add("scale", scale).add("entry", i), "taken", taken(config) == (i == 2 && scale == scale));
    }
  }
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
  const int codes[] = {segcal_push_imu(device, &sample),
                       segcal_push_tracks(device, 0, nullptr, 0),
                       segcal_push_keyframe(device, &state, nullptr, 0),
                       segcal_background(device, 1),
                       segcal_flush(device),
                       segcal_new_session(device),
                       segcal_calibrate(device),
                       segcal_get_state(device, &state),
                       segcal_get_camera(device, 0, &camera),
                       segcal_get_imu_calibration(device, &imu),
                       segcal_get_result(device, &result),
                       segcal_get_direction(device, 0, &direction),
                       segcal_get_segment(device, -1, &segment),
                       segcal_get_segment_directions(device, &direction, 1),
                       segcal_get_counters(device, &counters)};
  TEST_ASSERT_TRUE(segcal_result_hash(device) == 0);
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
  RUN_TEST(test_ranges_of_numbers);
  RUN_TEST(test_ranges_of_the_others);
  RUN_TEST(test_ranges_of_choices);
  RUN_TEST(test_ranges_of_a_camera);
  RUN_TEST(test_configuration_comes_back);
  RUN_TEST(test_calls_without_a_device);
  RUN_TEST(test_null_pointers);
  RUN_TEST(test_calls_too_early);
  RUN_TEST(test_refused_data_are_counted);
  RUN_TEST(test_points_that_are_no_numbers_are_dropped);
  return UNITY_END();
}
