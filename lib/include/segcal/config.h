/* Capacities and features, chosen at compile time. Every macro may be given with -D; a profile sets the rest.
   All memory of segcal follows from this page: see SEGCAL_STORAGE_BYTES in segcal.h. */
#ifndef SEGCAL_CONFIG_H
#define SEGCAL_CONFIG_H

#define SEGCAL_PROFILE_MCU 1
#define SEGCAL_PROFILE_MOBILE 2
#define SEGCAL_PROFILE_HOST 3

#ifndef SEGCAL_PROFILE
#define SEGCAL_PROFILE SEGCAL_PROFILE_MOBILE
#endif

#if SEGCAL_PROFILE == SEGCAL_PROFILE_MCU
#define SEGCAL_DEFAULT_NS segcal_mcu
#define SEGCAL_DEFAULT_CAMERAS 1
#define SEGCAL_DEFAULT_SEGMENTS 8
#define SEGCAL_DEFAULT_KEYFRAMES 12
#define SEGCAL_DEFAULT_LANDMARKS 40
#define SEGCAL_DEFAULT_OBSERVATIONS 360
#define SEGCAL_DEFAULT_IMU_SAMPLES 426
#define SEGCAL_DEFAULT_CLONES 8
#define SEGCAL_DEFAULT_TRACKS 40
#define SEGCAL_DEFAULT_FRAME_FEATURES 6
#define SEGCAL_DEFAULT_START_DELAY_MS 500
#define SEGCAL_DEFAULT_WAITING_FRAMES 3
#define SEGCAL_DEFAULT_TIES 0
#define SEGCAL_DEFAULT_EPOCHS 0
#define SEGCAL_DEFAULT_IMU_HISTORY 300
#define SEGCAL_DEFAULT_EFFECT_ESTIMATES 1
#define SEGCAL_DEFAULT_EFFECT_COLUMNS 3
#define SEGCAL_DEFAULT_PIXEL_BITS 16
#define SEGCAL_DEFAULT_TRACK_WALK 0
#define SEGCAL_DEFAULT_KEEP_ELIMINATIONS 0
#elif SEGCAL_PROFILE == SEGCAL_PROFILE_MOBILE
#define SEGCAL_DEFAULT_NS segcal_mobile
#define SEGCAL_DEFAULT_CAMERAS 2
#define SEGCAL_DEFAULT_SEGMENTS 15
#define SEGCAL_DEFAULT_KEYFRAMES 20
#define SEGCAL_DEFAULT_LANDMARKS 120
#define SEGCAL_DEFAULT_OBSERVATIONS 2000
#define SEGCAL_DEFAULT_IMU_SAMPLES 2000
#define SEGCAL_DEFAULT_CLONES 19
#define SEGCAL_DEFAULT_TRACKS 160
#define SEGCAL_DEFAULT_FRAME_FEATURES 30
#define SEGCAL_DEFAULT_START_DELAY_MS 0
#define SEGCAL_DEFAULT_WAITING_FRAMES 4
#define SEGCAL_DEFAULT_TIES 8
#define SEGCAL_DEFAULT_EPOCHS 4
#define SEGCAL_DEFAULT_IMU_HISTORY 1000
#define SEGCAL_DEFAULT_PIXEL_BITS 32
#define SEGCAL_DEFAULT_TRACK_WALK 1
#define SEGCAL_DEFAULT_KEEP_ELIMINATIONS 1
#define SEGCAL_DEFAULT_EFFECT_ESTIMATES 36
#define SEGCAL_DEFAULT_EFFECT_COLUMNS 42
#elif SEGCAL_PROFILE == SEGCAL_PROFILE_HOST
#define SEGCAL_DEFAULT_NS segcal_host
#define SEGCAL_DEFAULT_CAMERAS 2
#define SEGCAL_DEFAULT_SEGMENTS 64
#define SEGCAL_DEFAULT_KEYFRAMES 32
#define SEGCAL_DEFAULT_LANDMARKS 256
#define SEGCAL_DEFAULT_OBSERVATIONS 6000
#define SEGCAL_DEFAULT_IMU_SAMPLES 8400
#define SEGCAL_DEFAULT_CLONES 19
#define SEGCAL_DEFAULT_TRACKS 256
#define SEGCAL_DEFAULT_FRAME_FEATURES 30
#define SEGCAL_DEFAULT_START_DELAY_MS 0
#define SEGCAL_DEFAULT_WAITING_FRAMES 4
#define SEGCAL_DEFAULT_TIES 16
#define SEGCAL_DEFAULT_EPOCHS 4
#define SEGCAL_DEFAULT_IMU_HISTORY 2000
#define SEGCAL_DEFAULT_PIXEL_BITS 32
#define SEGCAL_DEFAULT_TRACK_WALK 1
#define SEGCAL_DEFAULT_KEEP_ELIMINATIONS 1
#define SEGCAL_DEFAULT_EFFECT_ESTIMATES 64
#define SEGCAL_DEFAULT_EFFECT_COLUMNS 64
#else
#error "SEGCAL_PROFILE: 1 (mcu), 2 (mobile) or 3 (host)"
#endif

/* The C++ namespace of this build. It follows the prefix, so that two builds in one program never share a type or a
   function, whatever their capacities. */
#ifndef SEGCAL_NS
#ifdef SEGCAL_RENAME
#include "segcal/symbol_names.h"
#define SEGCAL_NS SEGCAL_NAME(core)
#else
#define SEGCAL_NS SEGCAL_DEFAULT_NS
#endif
#endif
/* Cameras per device. Each adds 14 entries to the calibration vector. */
#ifndef SEGCAL_MAX_CAMERAS
#define SEGCAL_MAX_CAMERAS SEGCAL_DEFAULT_CAMERAS
#endif
/* Segments kept in the database; one more slot is the segment being built. */
#ifndef SEGCAL_MAX_SEGMENTS
#define SEGCAL_MAX_SEGMENTS SEGCAL_DEFAULT_SEGMENTS
#endif
/* Keyframes of a segment. */
#ifndef SEGCAL_MAX_KEYFRAMES
#define SEGCAL_MAX_KEYFRAMES SEGCAL_DEFAULT_KEYFRAMES
#endif
/* Landmarks of a segment; more tracks than this: the longest are kept. */
#ifndef SEGCAL_MAX_LANDMARKS
#define SEGCAL_MAX_LANDMARKS SEGCAL_DEFAULT_LANDMARKS
#endif
/* Image points of a segment, over all keyframes, landmarks and cameras. */
#ifndef SEGCAL_MAX_OBSERVATIONS
#define SEGCAL_MAX_OBSERVATIONS SEGCAL_DEFAULT_OBSERVATIONS
#endif
/* Bits of a stored image coordinate: 32 (float), or 16: steps of 1/32 px from -64 to 1983 px; points beyond are left
   out and counted. */
#ifndef SEGCAL_PIXEL_BITS
#define SEGCAL_PIXEL_BITS SEGCAL_DEFAULT_PIXEL_BITS
#endif
/* 1: the errors of a corner along its track may have a random walk (segcal_config_t.track_walk). 0: leaves that code
   out, some kB, and stack. */
#ifndef SEGCAL_TRACK_WALK
#define SEGCAL_TRACK_WALK SEGCAL_DEFAULT_TRACK_WALK
#endif
/* 1: a calibration keeps what it has made of each segment from one pass to the next: some 1.8 times as fast, for as
   much memory again as the segments take. 0: it makes it anew, with the same bits. It is part of SEGCAL_STORAGE_BYTES:
   a program that has 0 gives a library that has 1 too little memory (SEGCAL_ERROR_SIZE). */
#ifndef SEGCAL_KEEP_ELIMINATIONS
#define SEGCAL_KEEP_ELIMINATIONS SEGCAL_DEFAULT_KEEP_ELIMINATIONS
#endif
/* IMU samples of a segment; a sensor that is faster is averaged (segment_s). When they run out the segment ends early.
 */
#ifndef SEGCAL_MAX_IMU_SAMPLES
#define SEGCAL_MAX_IMU_SAMPLES SEGCAL_DEFAULT_IMU_SAMPLES
#endif
/* Past poses in the filter's state. */
#ifndef SEGCAL_MAX_CLONES
#define SEGCAL_MAX_CLONES SEGCAL_DEFAULT_CLONES
#endif
/* Feature tracks that the filter follows at the same time, per camera. */
#ifndef SEGCAL_MAX_TRACKS
#define SEGCAL_MAX_TRACKS SEGCAL_DEFAULT_TRACKS
#endif
/* What the features of one frame may cost the filter, in features that the whole window sees. The others wait, as long
   as they are seen. It bounds the time of a frame. */
#ifndef SEGCAL_FRAME_FEATURES
#define SEGCAL_FRAME_FEATURES SEGCAL_DEFAULT_FRAME_FEATURES
#endif
/* The filter's start in motion is background work, which takes effect this long (ms) after the frames that it was made
   from, so that it does not matter when it was done. 0: it is done at once, in one long frame. The IMU history must
   hold those frames and this time. At most 1500: the filter begins anew after 2 s without a feature. */
#ifndef SEGCAL_START_DELAY_MS
#define SEGCAL_START_DELAY_MS SEGCAL_DEFAULT_START_DELAY_MS
#endif
#if SEGCAL_START_DELAY_MS > 1500
#error "SEGCAL_START_DELAY_MS: 0 to 1500; the filter begins anew after 2 s without a feature: a later start never stays"
#endif

/* Frames that may wait for the IMU samples of their time, which come late from sensors with a FIFO: a block may last
   this many times frame_interval_s. */
#ifndef SEGCAL_WAITING_FRAMES
#define SEGCAL_WAITING_FRAMES SEGCAL_DEFAULT_WAITING_FRAMES
#endif

/* Landmarks that calibration shares between segments across gaps, over all segments together; four of them put two
   segments into one frame. 0: segments across a gap share biases only. */
#ifndef SEGCAL_MAX_TIES
#define SEGCAL_MAX_TIES SEGCAL_DEFAULT_TIES
#endif
/* Epochs: triangles that hold what segments said about the calibration once they are kept no longer
   (segcal_config_t.condense). When there is no room for another, the two oldest become one. 0: leaves that code out. */
#ifndef SEGCAL_MAX_EPOCHS
#define SEGCAL_MAX_EPOCHS SEGCAL_DEFAULT_EPOCHS
#endif
#if SEGCAL_MAX_EPOCHS == 1
#error "SEGCAL_MAX_EPOCHS: 0, or at least 2: when there is no place for another epoch, the two oldest become one"
#endif
/* Sessions whose triangles are kept beside epochs, to tell steps of the calibration from trends and from temperature
   (segcal_get_course). From four epochs on: fewer are for small memories. */
#define SEGCAL_MAX_HISTORY (SEGCAL_MAX_EPOCHS < 4 ? 0 : 2 * SEGCAL_MAX_EPOCHS)
/* Tracks in common from which on two segments of one map are put into one frame. Position and rotation about gravity
   are four unknowns and three landmarks of known depth fix them; in a short look at a scene about every second track
   has that, so that eight leave a choice and one or two mistaken ones do not decide. */
#ifndef SEGCAL_SHARED_LANDMARKS
#define SEGCAL_SHARED_LANDMARKS 8
#endif

/* IMU samples, averaged ones where they are, kept for the filter's start (1.5 s at least) and for cutting segments. */
#ifndef SEGCAL_IMU_HISTORY
#define SEGCAL_IMU_HISTORY SEGCAL_DEFAULT_IMU_HISTORY
#endif

/* Terms of effects that can be estimated beside the calibration at a time (time_offset is one term, gyro_g_sensitivity
   nine). Each kept segment's stored triangle grows by them. */
#ifndef SEGCAL_MAX_EFFECT_ESTIMATES
#if defined(SEGCAL_MAX_EFFECT_COLUMNS) && SEGCAL_MAX_EFFECT_COLUMNS < SEGCAL_DEFAULT_EFFECT_ESTIMATES
#define SEGCAL_MAX_EFFECT_ESTIMATES SEGCAL_MAX_EFFECT_COLUMNS
#else
#define SEGCAL_MAX_EFFECT_ESTIMATES SEGCAL_DEFAULT_EFFECT_ESTIMATES
#endif
#endif
/* Terms in one linearisation: those estimated, and candidates that are only tested. 0: no effects at all. */
#ifndef SEGCAL_MAX_EFFECT_COLUMNS
#define SEGCAL_MAX_EFFECT_COLUMNS SEGCAL_DEFAULT_EFFECT_COLUMNS
#endif

/* Arithmetic of the core: float by default; the host's cross-check builds with double. */
#ifndef SEGCAL_REAL
#define SEGCAL_REAL float
#endif

#endif
