/* Replays the recorded session from feed to calibration and prints what budgets and comparisons need, as "name value" lines.
 * The same program on every target; exit code 0: calibrated. */
#include "marks.h"
#include "print.h"
#include "session.h"
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
#include "stack.h"
#endif

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config;
static segcal_result_t result;
static segcal_segment_t segment;
static segcal_point_t points[SEGCAL_MAX_TRACKS];
static segcal_counters_t counters;
static segcal_t *device;
static uint32_t closed_segments;
/* What an idle task does between two IMU samples: enough that a score and the filter's start are done in time. */
enum { slices_per_sample = 8 };

/* Paint is renewed before each call whose stack is of interest. */
static void measure_begin(void) {
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
  static uint32_t painted;
  if (!painted) stack_paint();
  painted = 1;
#endif
  segcal_mark_begin();
}

static int closed_a_segment(void) {
  segcal_get_counters(device, &counters);
  const int more = counters.segments_closed != closed_segments;
  closed_segments = counters.segments_closed;
  return more;
}

/* A closed segment waits for its score, unless it was discarded or missed; the newest score's serial number tells. */
static int score_pending(void) {
  static uint32_t scored, newest;
  if (segcal_get_segment(device, -1, &segment) == SEGCAL_OK && (scored == 0 || segment.serial != newest)) {
    newest = segment.serial;
    ++scored;
  }
  return closed_segments - counters.segments_missed - counters.segments_late - counters.segments_discarded > scored;
}

/* At most so many slices of background work, each measured apart. Returns whether some are left. */
static int work_in_background(int slices) {
  int waiting = 1;
  for (; waiting > 0 && slices > 0; --slices) {
    const int scoring = score_pending();
    measure_begin();
    waiting = segcal_background(device, 1);
    if (scoring) {
      segcal_mark_score_slice();
    } else {
      segcal_mark_calibrate_slice();
    }
  }
  return waiting > 0;
}

static void feed_imu_until(int64_t t_ns) {
  static uint32_t next;
  while (next < session_samples()) {
    const segcal_imu_t sample = session_sample(next++);
    measure_begin();
    segcal_push_imu(device, &sample);
    segcal_mark_imu_sample();
    work_in_background(slices_per_sample);
    if (sample.t_ns >= t_ns) return;
  }
}

static void feed(void) {
  session_frame_t at;
  session_first_frame(&at);
  for (uint32_t i = 0; i < session_frames(); ++i) {
    int64_t t_ns;
    const int32_t n = session_next_frame(&at, &t_ns, points);
    feed_imu_until(t_ns);
    measure_begin();
    segcal_push_tracks(device, t_ns, points, n);
    if (closed_a_segment()) {
      segcal_mark_frame_closing();
    } else {
      segcal_mark_frame();
    }
  }
  while (work_in_background(1)) {
  }
}

static void print_results(void) {
  const segcal_result_t *r = &result;
  segcal_get_result(device, &result);
  print_number("state_bytes", (uint32_t)segcal_storage_bytes());
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
  print_number("stack_painted_bytes", stack_high_water() - stack_in_use());
#endif
  print_number("segments_closed", closed_segments);
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
  feed();
  segcal_flush(device); /* what was calibrated takes effect; not a call of the stream, so it is not measured */
  if (segcal_get_result(device, &result) != SEGCAL_OK) {
    measure_begin();
    segcal_calibrate(device);
    segcal_mark_calibrate();
  }
  print_results();
  return result.status == SEGCAL_CALIBRATED ? 0 : 1;
}
