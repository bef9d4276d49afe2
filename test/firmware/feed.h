/* Calls of the C API between the instruction counter's marks (marks.h), the same in every program that is measured. */
#ifndef SEGCAL_TEST_FEED_H
#define SEGCAL_TEST_FEED_H

#include "marks.h"
#include "segcal/segcal.h"

/* The call that processed an image, whichever it was; a segment may have ended in it. */
static inline void mark_image(segcal_t* device) {
  static segcal_counters_t counters;
  static uint32_t closed_segments;
  segcal_get_counters(device, &counters);
  if (counters.segments_closed != closed_segments) {
    segcal_mark_frame_closing();
  } else {
    segcal_mark_frame();
  }
  closed_segments = counters.segments_closed;
}

/* An image that waited for its IMU samples is processed in the call of the last of them. */
static inline void feed_sample(segcal_t* device, const segcal_imu_t* sample) {
  segcal_mark_begin();
  if (segcal_push_imu(device, sample) == SEGCAL_OK) {
    segcal_mark_imu_sample();
  } else {
    mark_image(device);
  }
}

/* One that waits is copied, no more; but where the filter's start is not background work, a start that fails says so
 * too. */
static inline void feed_frame(segcal_t* device, int64_t t_ns, const segcal_point_t* points, int32_t n) {
  segcal_mark_begin();
  if (segcal_push_tracks(device, t_ns, points, n) == SEGCAL_WAITING && SEGCAL_START_DELAY_MS > 0) {
    segcal_mark_imu_sample();
  } else {
    mark_image(device);
  }
}

/* At most so many slices of background work, each for itself. Returns whether some are left. */
static inline int feed_background(segcal_t* device, int slices) {
  int waiting = 1;
  for (; waiting > 0 && slices > 0; --slices) {
    segcal_progress_t progress;
    segcal_progress(device, &progress);
    segcal_mark_begin();
    waiting = segcal_background(device, 1);
    if (progress.work == SEGCAL_WORK_START) {
      segcal_mark_start_slice();
    } else if (progress.work == SEGCAL_WORK_CALIBRATION) {
      segcal_mark_calibrate_slice();
    } else {
      segcal_mark_score_slice();
    }
  }
  return waiting > 0;
}

#endif
