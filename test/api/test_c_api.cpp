// The C API as firmware uses it: storage of any content, error codes for bad arguments and bad data, a state that stays
// valid after each of them.
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "../support/cases.h"
#include "../support/synthetic_stream.h"

using test::Id;
using test::SyntheticStream;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// Aligned memory of the caller, filled with one byte.
class Storage {
 public:
  explicit Storage(int fill, std::size_t offset = 0) : bytes_(segcal_storage_bytes() + 2 * SEGCAL_STORAGE_ALIGNMENT) {
    std::memset(bytes_.data(), fill, bytes_.size());
    const std::uintptr_t address = reinterpret_cast<std::uintptr_t>(bytes_.data());
    data = bytes_.data() + (SEGCAL_STORAGE_ALIGNMENT - address % SEGCAL_STORAGE_ALIGNMENT) % SEGCAL_STORAGE_ALIGNMENT + offset;
  }
  unsigned char* data;

 private:
  std::vector<unsigned char> bytes_;
};

segcal_t* create(Storage* storage, const segcal_config_t& config) {
  segcal_t* device = nullptr;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_create(&device, &config, storage->data, segcal_storage_bytes()));
  TEST_ASSERT_NOT_NULL(device);
  return device;
}

const SyntheticStream& stream() {
  static const SyntheticStream instance(201, 9);
  return instance;
}

enum class Way { tracks, keyframes };

/// Data that must be refused, at one moment of the stream.
void push_rubbish(segcal_t* device, const segcal_imu_t& now, const SyntheticStream::Frame& frame) {
  segcal_imu_t bad = now;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STAMP, segcal_push_imu(device, &now));
  bad.t_ns = now.t_ns - 123456;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STAMP, segcal_push_imu(device, &bad));
  bad = now;
  bad.t_ns += 1;
  for (float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    bad.gyro[1] = value;
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NOT_FINITE, segcal_push_imu(device, &bad));
    bad.gyro[1] = 0;
    bad.accel[2] = -value;
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NOT_FINITE, segcal_push_imu(device, &bad));
    bad.accel[2] = 0;
  }
  std::vector<segcal_point_t> points = frame.points;
  const int n = static_cast<int>(points.size());
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STAMP, segcal_push_tracks(device, frame.state.t_ns, points.data(), n));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_push_tracks(device, now.t_ns + 1, nullptr, n));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_push_tracks(device, now.t_ns + 1, points.data(), -1));
  points[0].camera = 7;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CAMERA, segcal_push_tracks(device, now.t_ns + 1, points.data(), n));
  segcal_state_t state = frame.state;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CAMERA, segcal_push_keyframe(device, &state, points.data(), n));
  points[0].camera = 0;
  state.p_GI[0] = std::nan("");
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NOT_FINITE, segcal_push_keyframe(device, &state, points.data(), n));
}

void push_frame(segcal_t* device, const SyntheticStream::Frame& frame, Way way) {
  const int n = static_cast<int>(frame.points.size());
  const int code = way == Way::tracks ? segcal_push_tracks(device, frame.state.t_ns, frame.points.data(), n)
                                      : segcal_push_keyframe(device, &frame.state, frame.points.data(), n);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(0, code);
}

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
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_calibrate(device));
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
  RUN_TEST(test_nothing_is_written_behind_the_storage);
  RUN_TEST(test_storage_content_and_refused_data_change_nothing_with_keyframes);
  RUN_TEST(test_storage_content_and_refused_data_change_nothing_with_tracks);
  return UNITY_END();
}
