// What a device says when nothing comes of its data: one cause for each way in which a stream is broken.
#include <algorithm>

#include "api_fixture.h"
#include "segcal/health.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

constexpr int kSeconds = 24;

struct Broken {
  bool imu = true, frames = true;
  void (*sample)(segcal_imu_t*) = [](segcal_imu_t*) {};
  void (*frame)(SyntheticStream::Frame*) = [](SyntheticStream::Frame*) {};
  double every_s = 0;  ///< frames at least so far apart
  double from = 0;     ///< s of a good stream before
  double seconds = kSeconds;
  double gyro_range = 0, accel_range = 0, imu_rate_hz = 0;
  int every_sample = 1;  ///< of those at 200 Hz
  Way way = Way::tracks;
  int every_keyframe = 1;  ///< of those at 10 Hz
};

/// The device's answer after the whole stream.
int health_after(const Broken& how) {
  static Storage storage(0);
  segcal_config_t config = SyntheticStream::config();
  config.gyro_range = how.gyro_range;
  config.accel_range = how.accel_range;
  config.imu_rate_hz = how.imu_rate_hz;
  segcal_t* const device = create(&storage, config);
  double last = -1e9;
  for (std::size_t i = 0; i < long_stream<kSeconds>().imu.size() && 5e-3 * double(i) < how.seconds; ++i) {
    const double t = 5e-3 * double(i);
    const bool broken = t >= how.from;
    if ((how.frames || !broken) && i % 20 == 0 && (!broken || t - last >= how.every_s - 1e-6)) {
      last = t;
      SyntheticStream::Frame frame = long_stream<kSeconds>().frames[i / 20];
      if (broken) how.frame(&frame);
      const int32_t n = std::min(static_cast<int32_t>(frame.points.size()), SEGCAL_MAX_TRACKS);
      if (how.way == Way::tracks) segcal_push_tracks(device, frame.state.t_ns, frame.points.data(), n);
    }
    segcal_imu_t sample = long_stream<kSeconds>().imu[i];
    if (broken) how.sample(&sample);
    if ((how.imu || !broken) && i % std::size_t(how.every_sample) == 0) segcal_push_imu(device, &sample);
    if (how.way == Way::keyframes && i % std::size_t(20 * how.every_keyframe) == 0)
      push_frame(device, long_stream<kSeconds>().frames[i / 20], how.way);
    segcal_background(device, 8);
  }
  return segcal_get_health(device);
}

void check(const char* what, int expected, const Broken& how) {
  const int health = health_after(how);
  test::check_true(Id().add(what, 1).add("from", how.from).add("health", health), segcal_health_words(health),
                   health == expected);
}

/// Each from the beginning, and after eight seconds in which the odometry ran.
void test_each_cause_has_its_name() {
  for (const double from : {0.0, 8.0}) {
    const auto broken = [from](auto change) {
      Broken how;
      how.from = from;
      change(&how);
      return how;
    };
    check("nothing is wrong", SEGCAL_HEALTH_RUNNING, broken([](Broken*) {}));
    check("no samples", SEGCAL_HEALTH_NO_IMU, broken([](Broken* b) { b->imu = false; }));
    check("no frames", SEGCAL_HEALTH_NO_FRAMES, broken([](Broken* b) { b->frames = false; }));
    check("samples without values", SEGCAL_HEALTH_IMU_REFUSED, broken([](Broken* b) {
            b->sample = [](segcal_imu_t* s) { s->accel[0] = std::numeric_limits<float>::quiet_NaN(); };
          }));
    check("frames of another clock", SEGCAL_HEALTH_CLOCKS_APART,
          broken([](Broken* b) { b->frame = [](SyntheticStream::Frame* f) { f->state.t_ns += 3600000000000; }; }));
    check("a covered lens", SEGCAL_HEALTH_FEW_TRACKS,
          broken([](Broken* b) { b->frame = [](SyntheticStream::Frame* f) { f->points.resize(3); }; }));
    check("a mirrored image", SEGCAL_HEALTH_NO_START, broken([](Broken* b) {
            b->frame = [](SyntheticStream::Frame* f) {
              for (segcal_point_t& p : f->points) p.u = 640 - p.u;
            };
          }));
    check("a frame every 0.8 s", SEGCAL_HEALTH_FRAMES_TOO_FAR, broken([](Broken* b) { b->every_s = 0.8; }));
  }
}

void test_what_is_no_matter_of_time() {
  Broken how;
  how.frame = [](SyntheticStream::Frame* f) { f->state.t_ns -= f->state.t_ns % 1000000000; };
  check("stamps in whole seconds", SEGCAL_HEALTH_FRAMES_REFUSED, how);
  how = {};
  how.seconds = 0.5;
  check("the beginning", SEGCAL_HEALTH_STARTING, how);
  how = {};
  how.gyro_range = 2.3;
  check("a range too small", SEGCAL_HEALTH_SATURATED, how);
  how = {};
  how.sample = [](segcal_imu_t* s) { s->accel[2] += s->t_ns / 5000000 % 200 == 100 ? 30 : 0; };
  check("one sample a second that stands alone", SEGCAL_HEALTH_SPIKES, how);
  how = {};
  how.accel_range = 8;
  check("a range in g", SEGCAL_HEALTH_SATURATED, how);
  how = {};
  how.sample = [](segcal_imu_t* s) {
    for (float& a : s->accel) a *= 102;
  };
  check("accelerations in mg", SEGCAL_HEALTH_SATURATED, how);
  how = {};
  how.every_sample = 4;
  check("samples at a quarter of the rate", SEGCAL_HEALTH_IMU_RATE, how);
  how = {};
  how.imu_rate_hz = 1000;
  check("five times the rate is stated", SEGCAL_HEALTH_IMU_RATE, how);
  if (SEGCAL_IMU_HISTORY < 1000) {  // what is kept is meant to last ten times as long
    how = {};
    how.imu_rate_hz = 20;
    how.every_s = 0.4;
    check("a tenth of the rate is stated", SEGCAL_HEALTH_IMU_RATE, how);
  }
  how = {};
  how.way = Way::keyframes;
  how.every_keyframe = 14;
  check("keyframes 1.4 s apart", SEGCAL_HEALTH_NO_SEGMENTS, how);
  how.every_keyframe = 1;
  check("an odometry of the caller's", SEGCAL_HEALTH_RUNNING, how);
}

void test_bad_handles() { TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_health(nullptr)); }

/// Every code has words of its own, and unknown ones are said to be unknown.
void test_words() {
  for (int a = SEGCAL_HEALTH_RUNNING; a <= SEGCAL_HEALTH_NO_SEGMENTS; ++a) {
    for (int b = SEGCAL_HEALTH_RUNNING; b < a; ++b)
      TEST_ASSERT_NOT_EQUAL(0, std::strcmp(segcal_health_words(a), segcal_health_words(b)));
    TEST_ASSERT_NOT_EQUAL(0, std::strcmp(segcal_health_words(a), "unknown"));
  }
  TEST_ASSERT_EQUAL_STRING("unknown", segcal_health_words(-1));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_each_cause_has_its_name);
  RUN_TEST(test_what_is_no_matter_of_time);
  RUN_TEST(test_bad_handles);
  RUN_TEST(test_words);
  return UNITY_END();
}
