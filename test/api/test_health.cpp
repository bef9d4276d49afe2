// What a device says when nothing comes of its data: one cause for each way in which a stream is broken.
#include "api_fixture.h"
#include "segcal/health.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

constexpr double kSeconds = 16;
const SyntheticStream& long_stream() {
  static const SyntheticStream instance(7, kSeconds);
  return instance;
}

struct Broken {
  bool imu = true, frames = true;
  void (*sample)(segcal_imu_t*) = [](segcal_imu_t*) {};
  void (*frame)(SyntheticStream::Frame*) = [](SyntheticStream::Frame*) {};
  double every_s = 0;   ///< frames at least so far apart
  double seconds = kSeconds;
  double gyro_range = 0;
};

/// The device's answer after the whole stream.
int health_after(const Broken& how) {
  static Storage storage(0);
  segcal_config_t config = SyntheticStream::config();
  config.gyro_range = how.gyro_range;
  segcal_t* const device = create(&storage, config);
  double last = -1e9;
  for (std::size_t i = 0; i < long_stream().imu.size() && 5e-3 * double(i) < how.seconds; ++i) {
    if (how.frames && i % 20 == 0 && 5e-3 * double(i) - last >= how.every_s - 1e-6) {
      last = 5e-3 * double(i);
      SyntheticStream::Frame frame = long_stream().frames[i / 20];
      how.frame(&frame);
      segcal_push_tracks(device, frame.state.t_ns, frame.points.data(), static_cast<int32_t>(frame.points.size()));
    }
    segcal_imu_t sample = long_stream().imu[i];
    how.sample(&sample);
    if (how.imu) segcal_push_imu(device, &sample);
    segcal_background(device, 8);
  }
  return segcal_get_health(device);
}

void check(const char* what, int expected, const Broken& how) {
  const int health = health_after(how);
  test::check_true(Id().add(what, 1).add("health", health), segcal_health_words(health), health == expected);
}

void test_each_cause_has_its_name() {
  Broken how;
  check("nothing is wrong", SEGCAL_HEALTH_RUNNING, how);
  how.imu = false;
  check("no samples", SEGCAL_HEALTH_NO_IMU, how);
  how = {};
  how.frames = false;
  check("no frames", SEGCAL_HEALTH_NO_FRAMES, how);
  how = {};
  how.sample = [](segcal_imu_t* s) { s->accel[0] = std::numeric_limits<float>::quiet_NaN(); };
  check("samples without values", SEGCAL_HEALTH_IMU_REFUSED, how);
  how = {};
  how.frame = [](SyntheticStream::Frame* f) { f->state.t_ns += 3600000000000; };
  check("frames of another clock", SEGCAL_HEALTH_CLOCKS_APART, how);
  how = {};
  how.frame = [](SyntheticStream::Frame* f) { f->state.t_ns -= f->state.t_ns % 1000000000; };
  check("stamps in whole seconds", SEGCAL_HEALTH_FRAMES_REFUSED, how);
  how = {};
  how.frame = [](SyntheticStream::Frame* f) { f->points.resize(3); };
  check("a covered lens", SEGCAL_HEALTH_FEW_TRACKS, how);
  how = {};
  how.seconds = 0.5;
  check("the beginning", SEGCAL_HEALTH_STARTING, how);
  how = {};
  how.frame = [](SyntheticStream::Frame* f) {
    for (segcal_point_t& p : f->points) p.u = 640 - p.u;
  };
  check("a mirrored image", SEGCAL_HEALTH_NO_START, how);
  how = {};
  how.gyro_range = 2.0;
  check("a range too small", SEGCAL_HEALTH_SATURATED, how);
  how = {};
  how.every_s = 0.8;
  check("a frame every 0.8 s", SEGCAL_HEALTH_FRAMES_TOO_FAR, how);
}

void test_bad_handles() {
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_health(nullptr));
}

/// Every code has words of its own, and unknown ones are said to be unknown.
void test_words() {
  for (int a = SEGCAL_HEALTH_RUNNING; a <= SEGCAL_HEALTH_SATURATED; ++a) {
    for (int b = SEGCAL_HEALTH_RUNNING; b < a; ++b) TEST_ASSERT_NOT_EQUAL(0, std::strcmp(segcal_health_words(a), segcal_health_words(b)));
    TEST_ASSERT_NOT_EQUAL(0, std::strcmp(segcal_health_words(a), "unknown"));
  }
  TEST_ASSERT_EQUAL_STRING("unknown", segcal_health_words(-1));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_each_cause_has_its_name);
  RUN_TEST(test_bad_handles);
  RUN_TEST(test_words);
  return UNITY_END();
}
