// Cameras of few images per second, an odometry of few keyframes, and IMUs that deliver long blocks: they calibrate, or
// the device says what keeps it from that.
#include <algorithm>

#include "api_fixture.h"
#include "segcal/health.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

constexpr int kSeconds = 40;

segcal_config_t slow_config() {
  segcal_config_t config = SyntheticStream::config();
  config.keep_segments = 6;
  config.segment_s = 4;
  return config;
}

/// Every `step`-th frame of a stream at 10 images/s; samples come in blocks of `block`, after the frames of their time.
segcal_t* fed(Storage* storage, Way way, std::size_t step, std::size_t block) {
  segcal_t* const device = create(storage, slow_config());
  const SyntheticStream& stream = long_stream<kSeconds>();
  for (std::size_t i = 0; i < stream.imu.size(); i += block) {
    const std::size_t end = std::min(i + block, stream.imu.size());
    const auto frames = [&] {
      for (std::size_t k = (i + 19) / 20; 20 * k < end; ++k)
        if (k % step == 0) push_frame(device, stream.frames[k], way);
    };
    if (way == Way::tracks) frames();
    for (std::size_t k = i; k < end; ++k) segcal_push_imu(device, &stream.imu[k]);
    if (way == Way::keyframes) frames();
    segcal_background(device, 1000);
  }
  segcal_flush(device);
  return device;
}

/// Segments are as long as stated, whatever the distance of frames: all of their frames are keyframes.
void check_segments(Way way, double every_s) {
  static Storage storage(0);
  segcal_t* const device = fed(&storage, way, static_cast<std::size_t>(10 * every_s + 0.5), 1);
  const Id id = Id().add("way", static_cast<int>(way)).add("every_s", every_s);
  int kept = 0;
  for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
    segcal_segment_t s;
    if (segcal_get_segment(device, slot, &s) != SEGCAL_OK) continue;
    ++kept;
    const double seconds = 1e-9 * static_cast<double>(s.end_ns - s.start_ns);
    check_true(id, "as long as stated, but for two frames", seconds >= 4 - 2 * every_s && seconds <= 4 + every_s);
    check_true(id, "every frame is a keyframe", s.keyframes >= static_cast<int>(seconds / every_s + 0.5));
  }
  check_true(id.add("kept", kept), "enough to calibrate from", kept >= 4);
  segcal_calibrate(device);
  segcal_result_t result;
  check_true(id, "a result", segcal_get_result(device, &result) == SEGCAL_OK);
  check_true(id, "calibrated", result.status == SEGCAL_CALIBRATED);
}

void test_few_frames_per_second_calibrate() {
  for (const double every_s : {0.3, 0.5}) check_segments(Way::tracks, every_s);
  for (const double every_s : {0.5, 1.0}) check_segments(Way::keyframes, every_s);
}

void check_health(const char* what, int expected, std::size_t step, std::size_t block) {
  static Storage storage(0);
  const int health = segcal_get_health(fed(&storage, Way::tracks, step, block));
  check_true(Id().add(what, 1).add("health", health), segcal_health_words(health), health == expected);
}

/// The filter bridges 0.6 s; SEGCAL_WAITING_FRAMES images wait for their samples.
void test_what_cannot_run_is_said() {
  check_health("an image every 0.5 s", SEGCAL_HEALTH_RUNNING, 5, 1);
  check_health("an image every 0.7 s", SEGCAL_HEALTH_FRAMES_TOO_FAR, 7, 1);
  check_health("blocks of 0.25 s", SEGCAL_HEALTH_RUNNING, 1, 50);
  check_health("blocks of 1.2 s", SEGCAL_HEALTH_FRAMES_CROWDED, 1, 240);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_few_frames_per_second_calibrate);
  RUN_TEST(test_what_cannot_run_is_said);
  return UNITY_END();
}
