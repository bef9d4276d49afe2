/* Where a counted call begins and what it was: empty functions whose places the instruction counter
 * (test/budget/instruction_counter.c) knows by name. What a call was is only known afterwards, so the end carries it.
 */
#ifndef SEGCAL_TEST_MARKS_H
#define SEGCAL_TEST_MARKS_H

#define SEGCAL_MARK(name) \
  __attribute__((noinline, noclone, used)) static void name(void) { __asm volatile("" ::: "memory"); }

SEGCAL_MARK(segcal_mark_begin)
SEGCAL_MARK(segcal_mark_imu_sample)      /* one IMU sample */
SEGCAL_MARK(segcal_mark_frame)           /* the tracks of one image */
SEGCAL_MARK(segcal_mark_frame_closing)   /* the same, and it ended a segment */
SEGCAL_MARK(segcal_mark_score_slice)     /* a slice of background work while a score was pending */
SEGCAL_MARK(segcal_mark_calibrate_slice) /* any other slice of background work */
SEGCAL_MARK(segcal_mark_start_slice)     /* a slice of the filter's start */
SEGCAL_MARK(segcal_mark_calibrate)       /* a calibration in one call */

#endif
