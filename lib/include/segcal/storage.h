/* The ledger of all memory: what each part costs with the capacities in config.h, in bytes, for the default float core.
   An upper bound, at most a few per cent above the exact figure that segcal_storage_bytes() returns; the build fails if
   a line here becomes too small. */
#ifndef SEGCAL_STORAGE_H
#define SEGCAL_STORAGE_H

#include "segcal/config.h"

#define SEGCAL_REAL_BYTES sizeof(SEGCAL_REAL)
#define SEGCAL_SENSOR_COLUMNS (14u * SEGCAL_MAX_CAMERAS + 15u)
#define SEGCAL_THETA_COLUMNS (SEGCAL_SENSOR_COLUMNS + SEGCAL_MAX_EFFECT_ESTIMATES)
/* Theta with candidate terms: in the workspaces only. */
#define SEGCAL_WIDE_COLUMNS (SEGCAL_SENSOR_COLUMNS + SEGCAL_MAX_EFFECT_COLUMNS)
#define SEGCAL_TIE_COLUMNS (3u * SEGCAL_MAX_TIES)
#define SEGCAL_PACKED(n) ((n) * ((n) + 1u) / 2u)
#define SEGCAL_LARGER(a, b) ((a) > (b) ? (a) : (b))

/* One slot of the database: raw IMU samples, image points, states and landmarks, R_theta. */
#define SEGCAL_OBSERVATION_BYTES                                                                                  \
  (SEGCAL_PIXEL_BITS == 16 && SEGCAL_MAX_LANDMARKS < 512 && SEGCAL_MAX_KEYFRAMES <= 32 && SEGCAL_MAX_CAMERAS <= 2 \
       ? 6u                                                                                                       \
       : 4u + SEGCAL_PIXEL_BITS / 4u)
#define SEGCAL_SEGMENT_BYTES                                                                                         \
  (SEGCAL_MAX_IMU_SAMPLES * 14u + SEGCAL_MAX_IMU_SAMPLES / 4u + SEGCAL_MAX_OBSERVATIONS * SEGCAL_OBSERVATION_BYTES + \
   SEGCAL_MAX_KEYFRAMES * (21u * SEGCAL_REAL_BYTES + 8u) + SEGCAL_MAX_LANDMARKS * (7u * SEGCAL_REAL_BYTES + 6u) +    \
   SEGCAL_PACKED(SEGCAL_THETA_COLUMNS + 1u) * SEGCAL_REAL_BYTES + 160u)
#define SEGCAL_DATABASE_BYTES ((SEGCAL_MAX_SEGMENTS + 1u) * (SEGCAL_SEGMENT_BYTES + 1u) + 128u)

/* The filter: a triangle over its columns, a block of rows, one inertial link, its poses, the tracks it follows, and
   the points of one image as they were at its stamp. */
#define SEGCAL_FILTER_COLUMNS (24u + 6u * (SEGCAL_MAX_CLONES + 1u) + 14u * SEGCAL_MAX_CAMERAS)
#define SEGCAL_FILTER_BLOCK (SEGCAL_LARGER(2u * SEGCAL_MAX_CLONES + 3u, 18u) * (SEGCAL_FILTER_COLUMNS + 10u))
#define SEGCAL_FILTER_BYTES                                                                            \
  (SEGCAL_REAL_BYTES * (SEGCAL_PACKED(SEGCAL_FILTER_COLUMNS + 1u) +                                    \
                        SEGCAL_LARGER(SEGCAL_FILTER_BLOCK, SEGCAL_PACKED(SEGCAL_THETA_COLUMNS + 1u)) + \
                        SEGCAL_FILTER_COLUMNS + SEGCAL_LARGER(690u, 76u * (SEGCAL_MAX_CLONES + 1u)) +  \
                        24u * (SEGCAL_MAX_CLONES + 1u) + 200u * SEGCAL_MAX_CAMERAS + 100u) +           \
   16u * (SEGCAL_MAX_CLONES + 1u) +                                                                    \
   SEGCAL_MAX_CAMERAS * SEGCAL_MAX_TRACKS *                                                            \
       ((SEGCAL_MAX_CLONES + 1u) * 2u * SEGCAL_REAL_BYTES + 8u + 2u * SEGCAL_REAL_BYTES +              \
        (SEGCAL_MAX_EFFECT_ESTIMATES > 0 ? 8u + 2u * SEGCAL_REAL_BYTES : 0u)) +                        \
   256u)

/* Elimination of one segment: the reduced triangle; after each other in the same memory one landmark's rows, the chain
   of velocities and biases, and the work of an analysis. */
#define SEGCAL_REDUCED_COLUMNS (6u * (SEGCAL_MAX_KEYFRAMES - 1u) + 30u + SEGCAL_WIDE_COLUMNS + SEGCAL_TIE_COLUMNS + 1u)
#define SEGCAL_LANDMARK_NUMBERS \
  ((2u * SEGCAL_MAX_KEYFRAMES * SEGCAL_MAX_CAMERAS + 4u) * (SEGCAL_REDUCED_COLUMNS + 3u) + 10u)
#define SEGCAL_CHAIN_COLUMNS (49u + SEGCAL_MAX_EFFECT_COLUMNS + 6u * SEGCAL_MAX_KEYFRAMES)
#define SEGCAL_CHAIN_NUMBERS                                                                            \
  (9u * SEGCAL_CHAIN_COLUMNS + SEGCAL_LARGER(15u * SEGCAL_CHAIN_COLUMNS, 9u * SEGCAL_REDUCED_COLUMNS) + \
   SEGCAL_LARGER(690u, 6u * SEGCAL_REDUCED_COLUMNS) + 486u)
#define SEGCAL_LENT_NUMBERS                                                                      \
  (2u * SEGCAL_THETA_COLUMNS * SEGCAL_THETA_COLUMNS + SEGCAL_PACKED(SEGCAL_THETA_COLUMNS + 1u) + \
   8u * SEGCAL_THETA_COLUMNS + 300u)
#define SEGCAL_ELIMINATION_BYTES                                                                           \
  (SEGCAL_REAL_BYTES *                                                                                     \
       (SEGCAL_PACKED(SEGCAL_REDUCED_COLUMNS) +                                                            \
        SEGCAL_LARGER(SEGCAL_LARGER(SEGCAL_LANDMARK_NUMBERS, SEGCAL_CHAIN_NUMBERS), SEGCAL_LENT_NUMBERS) + \
        31u * (SEGCAL_MAX_EFFECT_COLUMNS + 1u) + 2u * SEGCAL_REDUCED_COLUMNS) +                            \
   272u)

/* Calibration: per segment one row block and later, in the same memory, saved states, or a segment that is built
   meanwhile; the chain between segments or the cost of one; the triangle of ties and theta, and who shares what with
   whom. */
#define SEGCAL_LINK_COLUMNS (30u + SEGCAL_WIDE_COLUMNS + SEGCAL_TIE_COLUMNS + 1u)
#define SEGCAL_LEFT_COLUMNS (15u + SEGCAL_THETA_COLUMNS + SEGCAL_TIE_COLUMNS + 1u)
#define SEGCAL_PARTITION_BYTES \
  ((SEGCAL_MAX_TIES + 1u) * (8u + 2u * SEGCAL_MAX_SEGMENTS) + SEGCAL_MAX_SEGMENTS * (SEGCAL_MAX_SEGMENTS + 1u))
#define SEGCAL_STATES_NUMBERS (21u * SEGCAL_MAX_KEYFRAMES + 7u * SEGCAL_MAX_LANDMARKS)
#define SEGCAL_KEPT_BYTES (SEGCAL_REAL_BYTES * SEGCAL_LARGER(SEGCAL_STATES_NUMBERS, 15u * SEGCAL_LEFT_COLUMNS - 105u))
#define SEGCAL_CALIBRATION_BYTES                                                                             \
  (SEGCAL_LARGER((SEGCAL_MAX_SEGMENTS - 1u) * SEGCAL_KEPT_BYTES, SEGCAL_SEGMENT_BYTES + SEGCAL_KEPT_BYTES) + \
   SEGCAL_REAL_BYTES * (SEGCAL_STATES_NUMBERS + SEGCAL_LARGER(31u * SEGCAL_LINK_COLUMNS - 435u, 480u) +      \
                        SEGCAL_PACKED(SEGCAL_WIDE_COLUMNS + SEGCAL_TIE_COLUMNS + 1u) + SEGCAL_LINK_COLUMNS + \
                        16u * SEGCAL_MAX_KEYFRAMES) +                                                        \
   SEGCAL_PARTITION_BYTES + 40u * SEGCAL_MAX_SEGMENTS + 180u * SEGCAL_REAL_BYTES)
/* What a fit keeps of each segment: its triangle above theta's rows (without effects and ties), and the integrals of
   its IMU links. */
#define SEGCAL_FIT_BYTES                                                                                              \
  (SEGCAL_KEEP_ELIMINATIONS == 0                                                                                      \
       ? 16u                                                                                                          \
       : SEGCAL_MAX_SEGMENTS * (SEGCAL_REAL_BYTES *                                                                   \
                                    (SEGCAL_PACKED(6u * SEGCAL_MAX_KEYFRAMES + 25u + SEGCAL_SENSOR_COLUMNS) -         \
                                     SEGCAL_PACKED(SEGCAL_SENSOR_COLUMNS + 1u) + 312u * SEGCAL_MAX_KEYFRAMES + 24u) + \
                                16u) +                                                                                \
             16u)
/* Reports: the directions of two. */
#define SEGCAL_REPORT_BYTES (2u * SEGCAL_REAL_BYTES * SEGCAL_THETA_COLUMNS * (SEGCAL_THETA_COLUMNS + 3u))

/* Samples and points on their way in. */
#define SEGCAL_INPUT_BYTES                                                                                        \
  (SEGCAL_IMU_HISTORY * (8u + 6u * SEGCAL_REAL_BYTES) +                                                           \
   SEGCAL_WAITING_FRAMES *                                                                                        \
       (SEGCAL_MAX_TRACKS * SEGCAL_MAX_CAMERAS * (8u + 2u * SEGCAL_REAL_BYTES) + 48u + 21u * SEGCAL_REAL_BYTES) + \
   6u * SEGCAL_MAX_LANDMARKS + 160u)

/* Terms of effects: the copies of theta, and sigmas and verdicts beside it. */
#define SEGCAL_EFFECT_BYTES \
  ((SEGCAL_MAX_EFFECT_ESTIMATES + 1u) * (10u * (4u + SEGCAL_REAL_BYTES) + 12u * SEGCAL_REAL_BYTES) + 256u)
/* The score tests' running triangle, and a test's work. */
#define SEGCAL_MONITOR_BYTES                                                                  \
  ((SEGCAL_PACKED(SEGCAL_WIDE_COLUMNS + 1u) + SEGCAL_PACKED(SEGCAL_MAX_EFFECT_COLUMNS + 1u) + \
    SEGCAL_MAX_EFFECT_COLUMNS * (SEGCAL_MAX_EFFECT_COLUMNS + 1u)) *                           \
       SEGCAL_REAL_BYTES +                                                                    \
   4u * SEGCAL_MAX_EFFECT_COLUMNS + 384u)

/* Epochs: rows over theta, theta; what the next segment hangs on; and changes. */
#define SEGCAL_EPOCH_BYTES                                                                                          \
  (SEGCAL_MAX_EPOCHS == 0                                                                                           \
       ? 32u                                                                                                        \
       : SEGCAL_MAX_EPOCHS *                                                                                        \
                 (SEGCAL_REAL_BYTES * (SEGCAL_PACKED(SEGCAL_THETA_COLUMNS + 1u) + 32u * SEGCAL_MAX_CAMERAS + 40u) + \
                  (SEGCAL_MAX_EFFECT_ESTIMATES + 1u) * (4u + SEGCAL_REAL_BYTES) + 80u) +                            \
             SEGCAL_REAL_BYTES *                                                                                    \
                 (15u * SEGCAL_LEFT_COLUMNS + 2u * (SEGCAL_MAX_EPOCHS + 1u) * SEGCAL_THETA_COLUMNS + 100u) +        \
             448u)

/* The history: rows over theta and theta of each session; its course, twice; and rates. */
#define SEGCAL_HISTORY_BYTES                                                                                        \
  (SEGCAL_MAX_HISTORY == 0                                                                                          \
       ? 16u                                                                                                        \
       : SEGCAL_MAX_HISTORY *                                                                                       \
                 (SEGCAL_REAL_BYTES * (SEGCAL_PACKED(SEGCAL_THETA_COLUMNS + 1u) + 32u * SEGCAL_MAX_CAMERAS + 40u) + \
                  (SEGCAL_MAX_EFFECT_ESTIMATES + 1u) * (4u + SEGCAL_REAL_BYTES) + 32u) +                            \
             SEGCAL_REAL_BYTES * (6u * SEGCAL_THETA_COLUMNS + 24u) + 128u)

/* In two blocks (blocks.h), or one behind the other. */
#define SEGCAL_COLD_BYTES \
  (SEGCAL_DATABASE_BYTES + SEGCAL_CALIBRATION_BYTES + SEGCAL_FIT_BYTES + SEGCAL_EFFECT_BYTES / 2u + 768u)
#define SEGCAL_HOT_BYTES                                                                                             \
  (SEGCAL_FILTER_BYTES + SEGCAL_ELIMINATION_BYTES + SEGCAL_REPORT_BYTES + SEGCAL_INPUT_BYTES + SEGCAL_EFFECT_BYTES + \
   SEGCAL_MONITOR_BYTES + SEGCAL_EPOCH_BYTES + SEGCAL_HISTORY_BYTES +                                                \
   (466u + 174u * SEGCAL_MAX_CAMERAS) * SEGCAL_REAL_BYTES + 768u)
#define SEGCAL_STORAGE_BYTES (SEGCAL_HOT_BYTES + SEGCAL_COLD_BYTES + 16u)

#endif
