/* Two minutes as a product has them, on a target: the IMU up to an image, then its tracks; the background gets
 * PRODUCT_SLICES slices after each sample (below 0: as many in bursts, five times a second), and two calibrations are
 * asked for. Each call that feeds and each slice is measured, so that the longest one is known whatever it had to do.
 * Exit code 0: calibrated, by two calibrations or more. */
#include "feed.h"
#include "print.h"
#include "session.h"

enum { burst_samples = 40, requests = 2 };

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config;
static segcal_result_t result;
static segcal_counters_t counters;
static segcal_t* device;

static void sample(uint32_t index, const segcal_imu_t* s) {
  feed_sample(device, s);
#if PRODUCT_SLICES < 0
  if (index % burst_samples == 0) feed_background(device, -(PRODUCT_SLICES)*burst_samples);
#else
  feed_background(device, PRODUCT_SLICES);
#endif
  if (index > 0 && index % (session_samples() / (requests + 1) + 1) == 0) segcal_request_calibration(device);
}

static void frame(int64_t t_ns, const segcal_point_t* points, int32_t n) { feed_frame(device, t_ns, points, n); }

int main(void) {
  session_config(&config);
  config.calibration_window = 8; /* some 28,000 slices, of 1,600 a second */
  if (!session_valid() || segcal_create(&device, &config, memory, sizeof memory) != SEGCAL_OK) {
    print_line("the session or the device cannot be opened");
    return 2;
  }
  session_feed(SESSION_NATURAL_ORDER, sample, frame);
  segcal_get_counters(device, &counters);
  const int status = segcal_get_result(device, &result);
  print_number("calibrations", counters.calibrations);
  print_number("late", counters.slices_late);
  print_number("segments_late", counters.segments_late);
  print_number("health", (uint32_t)segcal_get_health(device));
  print_hex("result_hash", segcal_result_hash(device));
  return status == SEGCAL_OK && result.status == SEGCAL_CALIBRATED && counters.calibrations >= requests ? 0 : 1;
}
