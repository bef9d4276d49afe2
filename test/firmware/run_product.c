/* Two minutes as a product has them, on a target: frames come when their time has come (in natural order: the IMU up to an image, then its
 * tracks), the background gets PRODUCT_SLICES slices after each sample (below 0: as many in bursts, five times a second), and two calibrations
 * are asked for. Each call that feeds and each slice is measured (marks.h), so that the longest one is known whatever it had to do; a segment that
 * ends does so in the call of a sample.
 * Exit code 0: calibrated, by two calibrations or more. */
#include "marks.h"
#include "print.h"
#include "session.h"

enum { burst_samples = 40, requests = 2 };

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config;
static segcal_result_t result;
static segcal_counters_t counters;
static segcal_point_t points[SEGCAL_MAX_TRACKS];
static segcal_t *device;
static uint32_t next_sample, closed_segments;

static void work(int slices) {
  for (; slices > 0; --slices) {
    segcal_progress_t progress;
    segcal_progress(device, &progress);
    segcal_mark_begin();
    const int waiting = segcal_background(device, 1);
    if (progress.work == SEGCAL_WORK_START) {
      segcal_mark_start_slice();
    } else if (progress.work == SEGCAL_WORK_CALIBRATION) {
      segcal_mark_calibrate_slice();
    } else {
      segcal_mark_score_slice();
    }
    if (waiting <= 0) return;
  }
}

static void idle_task(void) {
#if PRODUCT_SLICES < 0
  if (next_sample % burst_samples == 0) work(-(PRODUCT_SLICES) * burst_samples);
#else
  work(PRODUCT_SLICES);
#endif
}

static void feed_imu_until(int64_t t_ns) {
  while (next_sample < session_samples()) {
    const segcal_imu_t sample = session_sample(next_sample);
    if (sample.t_ns > t_ns) return;
    ++next_sample;
    segcal_mark_begin();
    segcal_push_imu(device, &sample);
    segcal_mark_imu_sample();
    idle_task();
    if (next_sample % (session_samples() / (requests + 1) + 1) == 0) segcal_request_calibration(device);
  }
}

static void feed_tracks(int64_t t_ns, int32_t n) {
  segcal_mark_begin();
  segcal_push_tracks(device, t_ns, points, n);
  segcal_get_counters(device, &counters);
  if (counters.segments_closed != closed_segments) {
    segcal_mark_frame_closing();
  } else {
    segcal_mark_frame();
  }
  closed_segments = counters.segments_closed;
}

static void feed(void) {
  session_frame_t at;
  session_first_frame(&at);
  for (uint32_t i = 0; i < session_frames(); ++i) {
    int64_t t_ns;
    const int32_t n = session_next_frame(&at, &t_ns, points);
    feed_imu_until(t_ns);
    feed_tracks(t_ns, n);
  }
}

int main(void) {
  session_config(&config);
  config.calibration_window = 8; /* some 28,000 slices, of 1,600 a second */
  if (!session_valid() || segcal_create(&device, &config, memory, sizeof memory) != SEGCAL_OK) {
    print_line("the session or the device cannot be opened");
    return 2;
  }
  feed();
  segcal_get_counters(device, &counters);
  const int status = segcal_get_result(device, &result);
  print_number("calibrations", counters.calibrations);
  print_number("late", counters.slices_late);
  print_number("segments_late", counters.segments_late);
  print_number("segments_used", (uint32_t)(status == SEGCAL_OK ? result.segments : 0));
  print_hex("result_hash", segcal_result_hash(device));
  return status == SEGCAL_OK && result.status == SEGCAL_CALIBRATED && counters.calibrations >= requests ? 0 : 1;
}
