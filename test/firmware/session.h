/* The recorded session (fixtures/firmware/session.bin, 40 s; session_120s.bin) that all targets replay: a device shaken
 * by hand, with 40 corner tracks, in the 16-bit units of a sensor. It is read where it lies. */
#ifndef SEGCAL_TEST_SESSION_H
#define SEGCAL_TEST_SESSION_H

#include "segcal/segcal.h"

/* The device that it was recorded with, as its data sheet has it. */
void session_config(segcal_config_t* config);

int session_valid(void);
uint32_t session_samples(void);
uint32_t session_frames(void);

segcal_imu_t session_sample(uint32_t index);

/* Frames are read in order: sets *t_ns and the points, returns their number. */
typedef struct {
  uint32_t offset;
} session_frame_t;
void session_first_frame(session_frame_t* at);
int32_t session_next_frame(session_frame_t* at, int64_t* t_ns, segcal_point_t points[SEGCAL_MAX_TRACKS]);

/* Feeds all of it. A frame comes after the first sample that is not earlier, which completes it; or, in natural order,
 * before it. */
typedef enum { SESSION_FRAME_AFTER_SAMPLE, SESSION_NATURAL_ORDER } session_order_t;
void session_feed(session_order_t order, void (*sample)(uint32_t index, const segcal_imu_t* sample),
                  void (*frame)(int64_t t_ns, const segcal_point_t* points, int32_t n));

#endif
