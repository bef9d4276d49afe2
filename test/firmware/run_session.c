/* Replays the recorded session from feed to calibration and prints what budgets and comparisons need, as "name value"
 * lines. The same program on every target; exit code 0: calibrated. */
#include "feed.h"
#include "print.h"
#include "segcal/blocks.h"
#include "session.h"
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
#include "stack.h"
#endif

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config;
static segcal_result_t result;
static segcal_counters_t counters;
static segcal_t* device;
/* What an idle task does between two IMU samples: enough that a score and the filter's start are done in time. */
enum { slices_per_sample = 8 };

static void sample(uint32_t index, const segcal_imu_t* s) {
  (void)index;
  feed_sample(device, s);
  feed_background(device, slices_per_sample);
}

static void frame(int64_t t_ns, const segcal_point_t* points, int32_t n) { feed_frame(device, t_ns, points, n); }

static void print_results(void) {
  const segcal_result_t* r = &result;
  segcal_get_result(device, &result);
  print_number("state_bytes", (uint32_t)segcal_storage_bytes());
  print_number("hot_bytes", (uint32_t)segcal_hot_bytes());
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
  print_number("stack_painted_bytes", stack_high_water() - stack_in_use());
#endif
  segcal_get_counters(device, &counters);
  print_number("segments_closed", counters.segments_closed);
  print_number("segments_used", (uint32_t)r->segments);
  print_number("iterations", (uint32_t)r->iterations);
  print_hex("result_hash", segcal_result_hash(device));
  for (int i = 0; i < r->n_parameters; ++i) {
    print_double(r->parameter[i].name, r->parameter[i].value);
    print_double("sigma", r->parameter[i].sigma);
  }
}

int main(void) {
  session_config(&config);
  if (!session_valid() || segcal_create(&device, &config, memory, sizeof memory) != SEGCAL_OK) {
    print_line("the session or the device cannot be opened");
    return 2;
  }
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
  stack_paint();
#endif
  session_feed(SESSION_FRAME_AFTER_SAMPLE, sample, frame);
  while (feed_background(device, 1)) {
  }
  segcal_flush(device); /* what was calibrated takes effect; not a call of the stream, so it is not measured */
  if (segcal_get_result(device, &result) != SEGCAL_OK) {
    segcal_mark_begin();
    segcal_calibrate(device);
    segcal_mark_calibrate();
  }
  print_results();
  return result.status == SEGCAL_CALIBRATED ? 0 : 1;
}
