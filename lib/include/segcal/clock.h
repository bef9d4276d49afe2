/* A camera's clock that nobody measured: its offset from the IMU's, found before a device is started.
 *
 * A device whose clocks are 30 ms apart does not start, or settles on a wrong answer; segcal.h's time_offset takes over
 * below some 10 ms. Here the rotation that images show is matched with the gyroscope's, at 201 offsets within half a
 * second of a start. Nothing is known of the scene and no odometry runs. A search is one block of the caller's, with
 * sums that do not grow with time; nothing waits: samples and images are noted, segcal_clock_background does the rest
 * in slices of bounded work. Link the library segcal_clock beside segcal.
 *
 *     static segcal_clock_t clock;                                 SEGCAL_CLOCK_BYTES
 *     segcal_clock_create(&clock, sizeof clock, &config.camera[0], 0, 0);
 *     do {                                                         a device that is turned about, for some 20 s
 *       segcal_clock_push_imu(&clock, &sample);                    as they come
 *       segcal_clock_push_tracks(&clock, image_ns, points, n);
 *       while (segcal_clock_background(&clock, 1) == 1) {}         in a task of low priority
 *       segcal_clock_get(&clock, &found);
 *     } while (found.status != SEGCAL_CLOCK_FOUND);
 *     offset_ns = (int64_t)(1e9 * found.offset_s);
 *     segcal_push_tracks(device, image_ns + offset_ns, points, n); as all images from then on
 *
 * Calls return SEGCAL_OK (0), a positive event, or a negative error of segcal.h; after an error the state is valid and,
 * counters apart, as if the call had not been made. Not for two threads at a time on the same search. The same calls
 * give the same bits on every target.
 */
#ifndef SEGCAL_CLOCK_H
#define SEGCAL_CLOCK_H

#include "segcal/segcal.h"

#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif
#ifdef __cplusplus
extern "C" {
#endif

/* ---- memory: two images of SEGCAL_MAX_TRACKS points, 1.9 s of what the gyroscope turned, and 201 sets of sums ---- */
#define SEGCAL_CLOCK_BYTES                                                                                        \
  (201u * 9u * SEGCAL_REAL_BYTES + SEGCAL_MAX_TRACKS * (6u * SEGCAL_REAL_BYTES + 12u) + 80u * SEGCAL_REAL_BYTES + \
   24u * (3u * SEGCAL_REAL_BYTES + 20u) + 384u * 12u + 320u)
#define SEGCAL_CLOCK_WORDS ((SEGCAL_CLOCK_BYTES + 7u) / 8u)
typedef struct {
  uint64_t memory[SEGCAL_CLOCK_WORDS]; /* holds no address: may be moved as bytes */
} segcal_clock_t;

/* ---- what is known ---- */
enum {
  SEGCAL_CLOCK_SEARCHING = 0, /* not enough yet, and nothing is wrong */
  SEGCAL_CLOCK_FOUND = 1,
  SEGCAL_CLOCK_FEW_IMAGES = 2, /* after ten seconds: too few images with common corners */
  SEGCAL_CLOCK_STILL = 3,      /* after ten seconds: the device turns too little, below 0.1 rad/s rms, or too evenly */
  SEGCAL_CLOCK_NO_AGREEMENT = 4, /* the rotations agree at no offset, or only at the end of what is tried */
  SEGCAL_CLOCK_REPEATS = 5       /* they agree at several: the motion repeats itself */
};

typedef struct {
  int32_t status;  /* SEGCAL_CLOCK_*; of what came until now: may change as more comes */
  double offset_s; /* t_imu = t_cam + offset_s, in all: the start is in it. Where FOUND; else only the best so far */
  /* s. How far answers from other stretches of the same kind of motion would lie from this one: noise, parallax, a lens
     and axes that are slightly wrong, as windows of two seconds scatter by them; and 2 ms for what is the same in all
     windows (parallax of a motion that always turns one way when it goes one way). Not in it: a rolling shutter, whose
     rows are stamped as the stamp says, and exposure. */
  double sigma_s;
  double correlation;           /* of the rates at the offset; 1: the same motion */
  double correlation_at_start;  /* where the start was right the two are the same */
  double correlation_elsewhere; /* the best more than 0.1 s from the offset */
  int32_t pairs, windows;       /* pairs of images that were used, in so many windows of two seconds */
  int32_t windows_still;        /* that turn too little and were left out */
  int32_t images_left_out; /* stamps that do not grow or are 2 s and more from the IMU's; or the background was not done
                              with the one before */
  int32_t pairs_left_out;  /* without samples of the gyroscope half a second around them, or too late for those that are
                              kept (1.9 s) */
} segcal_clock_result_t;

/* Begins a search in *clock (any content), `bytes` large: sizeof *clock. The camera as in segcal_config_t, and its
   index there: points of other cameras are passed over. It need not be precise: some per cent, some degrees. p_CI is
   not used. `start_s`: the offset t_imu - t_cam that is believed, [-1000, 1000]; tried is what is within half a second
   of it. SEGCAL_ERROR_SIZE: `bytes` are too few (this file was compiled with other capacities than the library);
   SEGCAL_ERROR_CONFIG, _CAMERA: out of range. */
int segcal_clock_create(segcal_clock_t* clock, size_t bytes, const segcal_camera_t* camera, int32_t index,
                        double start_s);
/* A sample; of its values only the rates are looked at. SEGCAL_ERROR_NOT_FINITE: not a number, or beyond 100 rad/s.
   Samples more than 0.1 s apart are a gap: images there tell nothing. */
int segcal_clock_push_imu(segcal_clock_t* clock, const segcal_imu_t* sample);
/* An image, as for segcal_push_tracks, with its stamp as it is. SEGCAL_WAITING: taken; SEGCAL_SKIPPED: less than 40 ms
   after the one before, or the background was not done with that one (counted). A track that comes twice in an image
   counts once. */
int segcal_clock_push_tracks(segcal_clock_t* clock, int64_t t_ns, const segcal_point_t* points, int32_t n);
/* At most `slices` pieces of work. 1: more is to do; else 0. An image takes about nine and one for each eight points,
   and one more half a second later. When it is called changes no bit of what comes out, as long as it is done with an
   image before the next one. */
int segcal_clock_background(segcal_clock_t* clock, int32_t slices);
/* At any time. The work of a slice. */
int segcal_clock_get(const segcal_clock_t* clock, segcal_clock_result_t* out);

/* What to do, a sentence for each status. Inline, so that firmware that does not print it does not carry it. */
static inline const char* segcal_clock_words(int32_t status) {
  switch (status) {
    case SEGCAL_CLOCK_SEARCHING:
      return "the search goes on: turn the device about, unevenly and about several axes, with the camera on things "
             "with corners";
    case SEGCAL_CLOCK_FOUND: return "found: add offset_s to the stamps of all images, then start the device";
    case SEGCAL_CLOCK_FEW_IMAGES:
      return "too few images with common corners: they should come 40 to 250 ms apart, share 12 tracks, be stamped "
             "within 2 s of the IMU's samples, and segcal_clock_background must be done with one before the next";
    case SEGCAL_CLOCK_STILL:
      return "the device turns too little to compare clocks: turn it about, by half a radian a second or more, now "
             "faster and now slower";
    case SEGCAL_CLOCK_NO_AGREEMENT:
      return "rotation of the images and of the gyroscope do not agree at any offset within 0.5 s of the start: check "
             "q_CI, the gyroscope's axes and units (rad/s), the focal length, and the stamps; or state another start";
    case SEGCAL_CLOCK_REPEATS:
      return "the motion repeats itself, so that offsets are not told apart: turn the device now faster and now slower";
    default: return "unknown";
  }
}

#ifdef __cplusplus
}
#endif
#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
#endif
