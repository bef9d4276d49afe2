/* segcal: keeps a camera and an IMU calibrated while they are used. The C API.
 *
 * All memory is the caller's: one block of SEGCAL_STORAGE_BYTES, nothing else, no heap. Calls return SEGCAL_OK (0), a
 * positive event, or a negative error; after an error the state is valid and as if the call had not been made. Not for
 * two threads at a time on the same device.
 *
 * Frames: G gravity aligned, z up; I the IMU (the gyroscope's axes); C the camera, x right, y down, z forward.
 * R_AB rotates a vector given in B into A; p_C = R_CI p_I + p_CI (Kalibr's T_cam_imu). Quaternions: Hamilton, w first.
 * Time: int64 nanoseconds of the IMU's clock. SI units unless the name says otherwise.
 */
#ifndef SEGCAL_H
#define SEGCAL_H

#include <stddef.h>
#include <stdint.h>

#include "segcal/config.h"
#ifdef SEGCAL_RENAME
#include "segcal/symbol_names.h"
#endif

/* All that a shared library exports: the core is compiled with -fvisibility=hidden. */
#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif
#ifdef __cplusplus
extern "C" {
#endif

/* ---- versions ---- */
#define SEGCAL_VERSION 0x00010000u /* major 16 bits, minor 16 bits */
uint32_t segcal_version(void);

/* ---- memory ---- */
/* Alignment of the storage, bytes. */
#define SEGCAL_STORAGE_ALIGNMENT 16
/* Upper bound of the storage, from the capacities in config.h; exact to a few per cent, checked when the library is
   built. segcal_storage_bytes() tells the exact figure. */
#include "segcal/storage.h"
size_t segcal_storage_bytes(void);

/* ---- limits ---- */
#define SEGCAL_MAX_PARAMETERS (SEGCAL_MAX_CAMERAS * 14 + 15 + SEGCAL_MAX_EFFECT_ESTIMATES)
#define SEGCAL_MAX_DIRECTIONS SEGCAL_MAX_PARAMETERS
#define SEGCAL_NAME_LENGTH 40
#define SEGCAL_UNIT_LENGTH 24

/* ---- return codes ---- */
enum {
  SEGCAL_OK = 0,
  SEGCAL_WAITING = 1,           /* taken; more data is needed before anything comes of it */
  SEGCAL_SKIPPED = 2,           /* a frame sooner than frame_interval_s after the last one used */
  SEGCAL_TRACKING = 3,          /* the frame moved the filter */
  SEGCAL_LOST = 4,              /* tracking was lost; the filter starts again, the open segment is ended */
  SEGCAL_NO_RESULT = 5,         /* calibration ran, but nothing is released: see the result's status */
  SEGCAL_EMPTY = 6,             /* nothing is stored (store.h) */
  SEGCAL_ERROR_NULL = -1,       /* a pointer is null */
  SEGCAL_ERROR_SIZE = -2,       /* storage smaller than segcal_storage_bytes(), or a count out of range */
  SEGCAL_ERROR_ALIGNMENT = -3,  /* storage not aligned to SEGCAL_STORAGE_ALIGNMENT */
  SEGCAL_ERROR_CONFIG = -4,     /* a configuration value out of its range */
  SEGCAL_ERROR_NOT_FINITE = -5, /* NaN or infinity in a sample, dropped and counted; a keyframe whose state is out of
                                   range, or with a point that is no number, dropped */
  SEGCAL_ERROR_STAMP = -6,  /* a stamp that repeats, goes back, is far from the others, or outside +-2^62 ns; dropped
                               and counted */
  SEGCAL_ERROR_CAMERA = -7, /* camera index out of range */
  SEGCAL_ERROR_STATE = -8,  /* call not possible now (no segment, not created) */
  SEGCAL_ERROR_BUSY = -9,   /* background work is under way and moves what was asked for: again when segcal_background
                               returns 0 and the calibration has taken effect, or after segcal_flush */
  SEGCAL_ERROR_CAPACITY = -10, /* header and library have other capacities (config.h): see
                                  segcal_explain_capacities */
  SEGCAL_ERROR_STORAGE = -11,  /* store.h: the medium failed */
  SEGCAL_ERROR_FULL = -12,     /* store.h: too few good blocks */
  SEGCAL_ERROR_VERSION = -13   /* store.h: stored by a newer major format */
};

/* ---- configuration: a struct of zeroes means all defaults, except for the camera itself ----
 * [a, b] is the range of a value; one outside it, or not a number, makes segcal_create return SEGCAL_ERROR_CONFIG.
 * Where 0 stands for a default, 0 is allowed beside the range. The square of a quaternion's length: [0.98, 1.02]. */
enum { SEGCAL_FOV = 0, SEGCAL_RADTAN = 1, SEGCAL_EQUIDISTANT = 2 };
enum {
  SEGCAL_METRIC_A = 0,
  SEGCAL_METRIC_D = 1,
  SEGCAL_METRIC_E = 2,
  SEGCAL_METRIC_RANDOM = 3,
  SEGCAL_METRIC_SET_D = 4
};
enum { SEGCAL_SINGLE_SESSION = 0, SEGCAL_MULTI_SESSION = 1 };

typedef struct {
  int32_t model;        /* SEGCAL_FOV, SEGCAL_RADTAN or SEGCAL_EQUIDISTANT */
  double q_CI[4];       /* rotates I into C, w x y z; {0,0,0,0}: identity */
  double p_CI[3];       /* m, [-100, 100] */
  double intrinsics[4]; /* fx fy cx cy, px; f [1, 1e5], c [-1e5, 1e5] */
  double distortion[4]; /* fov: w, rad, [0, 2.5]; radtan: k1 k2 p1 p2; equidistant: k1..k4; [-100, 100] */
  int32_t height;       /* lines of the image, for rolling_shutter, [-100000, 100000]: its rows; below zero: minus its
                           columns, where the shutter runs across the image (a phone held upright). 0: twice cy, rows */
} segcal_camera_t;

/* ---- effects: what the model may lack (docs/diagnosis.md, section 4) ----
 * An effect is a sum of terms, a term is one number that is estimated beside the calibration, behind its last entry.
 * Terms of the catalogue's effects come from segcal_effect_terms(); other terms of the same kinds may be given as well:
 *   SEGCAL_TERM_GYRO_X .. ACCEL_Z   c times the product of the signals a and b is added to the reading of this axis
 *   SEGCAL_TERM_IMAGE_U, IMAGE_V    c x^a y^b row^c is added to the distorted point, in units of the focal length;
 *                                   row runs from -1 at the top of the image to 1 at its bottom (columns: left, right)
 *   SEGCAL_TERM_CAMERA_WARMTH       c per degC above 25 of all cameras' a = 0..2: rotation (rad), 3: focal lengths, 4,
 * 5: centre, in units of the focal length What they do to a reading stands in lib/src/sensors/effect_terms.h. */
enum {
  SEGCAL_EFFECT_TIME_OFFSET = 1 << 0, /* t_d, s: t_imu = t_cam + t_d. Once released, stamps of frames are moved by it */
  SEGCAL_EFFECT_ROLLING_SHUTTER = 1 << 1, /* line delay, s/row, from the middle row (or column: segcal_camera_t) */
  SEGCAL_EFFECT_RADIAL_RESIDUAL = 1 << 2,
  SEGCAL_EFFECT_TANGENTIAL_RESIDUAL = 1 << 3,
  SEGCAL_EFFECT_GYRO_G_SENSITIVITY = 1 << 4,
  SEGCAL_EFFECT_GYRO_NONLINEARITY = 1 << 5,
  SEGCAL_EFFECT_ACCEL_NONLINEARITY = 1 << 6,
  SEGCAL_EFFECT_GYRO_TEMPERATURE = 1 << 7, /* needs segcal_imu_t.temperature */
  SEGCAL_EFFECT_ACCEL_TEMPERATURE = 1 << 8,
  SEGCAL_EFFECT_GYRO_LAG = 1 << 9,
  SEGCAL_EFFECT_ACCEL_AXIS_OFFSET = 1 << 10,
  SEGCAL_EFFECT_CAMERA_TEMPERATURE = 1 << 11 /* needs segcal_imu_t.temperature, and SEGCAL_MAX_EFFECT_COLUMNS 6; to be
                                                estimated SEGCAL_MAX_EFFECT_ESTIMATES 6; not with joint_filter */
};
#define SEGCAL_EFFECTS 12          /* how many there are: bits 0..11 */
#define SEGCAL_EFFECT_PARAMETERS 9 /* most parameters of an effect */

enum {
  SEGCAL_TERM_GYRO_X,
  SEGCAL_TERM_GYRO_Y,
  SEGCAL_TERM_GYRO_Z,
  SEGCAL_TERM_ACCEL_X,
  SEGCAL_TERM_ACCEL_Y,
  SEGCAL_TERM_ACCEL_Z,
  SEGCAL_TERM_GYRO_LAG,
  SEGCAL_TERM_AXIS_OFFSET,
  SEGCAL_TERM_CAMERA_TIME,
  SEGCAL_TERM_RADIAL,
  SEGCAL_TERM_TANGENTIAL_1,
  SEGCAL_TERM_TANGENTIAL_2,
  SEGCAL_TERM_IMAGE_U,
  SEGCAL_TERM_IMAGE_V,
  SEGCAL_TERM_CAMERA_WARMTH
};
/* Corrected readings, rad/s and m/s^2; DW: angular acceleration, rad/s^2; WARMTH: degC above 25; TIME: s since the
   first sample; HEADING: of I's x axis in the horizontal plane, from where the session began. Forces are in I for a
   term of the gyroscope, along the accelerometer's axes for one of the accelerometer. */
enum {
  SEGCAL_SIGNAL_ONE,
  SEGCAL_SIGNAL_WX,
  SEGCAL_SIGNAL_WY,
  SEGCAL_SIGNAL_WZ,
  SEGCAL_SIGNAL_ABS_WX,
  SEGCAL_SIGNAL_ABS_WY,
  SEGCAL_SIGNAL_ABS_WZ,
  SEGCAL_SIGNAL_ABS_W,
  SEGCAL_SIGNAL_FX,
  SEGCAL_SIGNAL_FY,
  SEGCAL_SIGNAL_FZ,
  SEGCAL_SIGNAL_DWX,
  SEGCAL_SIGNAL_DWY,
  SEGCAL_SIGNAL_DWZ,
  SEGCAL_SIGNAL_WARMTH,
  SEGCAL_SIGNAL_TIME,
  SEGCAL_SIGNAL_COS_HEADING,
  SEGCAL_SIGNAL_SIN_HEADING
};
typedef struct {
  uint8_t kind;    /* SEGCAL_TERM_* */
  uint8_t a, b, c; /* signals (SEGCAL_SIGNAL_*) or powers (up to 6); 0 where there is none */
} segcal_term_t;

typedef struct {
  const char* name; /* "time_offset" */
  int32_t n_parameters;
  const char* parameter[SEGCAL_EFFECT_PARAMETERS]; /* "t_d" */
  const char* unit;                                /* of each parameter */
  double prior_sigma;
  const char *looks_like, *confounded; /* one line each, for people */
} segcal_effect_t;

typedef struct {
  double gyro_scale[3];         /* [0.5001, 1.9999]; 0: 1 */
  double gyro_misalignment[3];  /* [-10, 10] */
  double accel_scale[3];        /* [0.5001, 1.9999]; 0: 1 */
  double accel_misalignment[3]; /* [-10, 10] */
  double q_AI[4];               /* rotates I into the accelerometer's axes; {0,0,0,0}: identity */
} segcal_imu_calibration_t;

typedef struct {
  int32_t n_cameras;                          /* 1..SEGCAL_MAX_CAMERAS; 0: 1 */
  segcal_camera_t camera[SEGCAL_MAX_CAMERAS]; /* the starting calibration, also the mean of the prior */
  segcal_imu_calibration_t imu;
  double imu_rate_hz;         /* [20, 20000]; 0: 200; a gap of more than 3 periods is a fault */
  double gyro_noise_density;  /* rad/s/sqrt(Hz), [1e-9, 1]; 0: 1.7e-4 */
  double gyro_random_walk;    /* rad/s^2/sqrt(Hz), [1e-9, 1]; 0: 2e-5 */
  double accel_noise_density; /* m/s^2/sqrt(Hz), [1e-9, 10]; 0: 2e-3 */
  double accel_random_walk;   /* m/s^3/sqrt(Hz), [1e-9, 10]; 0: 3e-4 */
  double gyro_range;          /* rad/s, full scale: a sample beyond is left out, [0.01, 1e4]; 0: 35 (2000 deg/s) */
  double accel_range;         /* m/s^2, not g, full scale, [0.1, 1e5]; 0: 157 (16 g) */
  double pixel_sigma;         /* px, corner noise per axis, [1e-3, 100]; 0: 0.5 */
  double gravity;             /* m/s^2, [1e-3, 100]; 0: 9.80665 */
  double frame_interval_s;    /* frames closer than this are skipped by the filter, [1e-3, 2]; 0: 0.1 */
  double segment_s; /* length of a segment, [0.1, 60]; 0: 4. A segment holds it with keyframes at equal distances */
  /* Segments of open length: quiet ones end from least_segment_s on, lively ones go on up to most_segment_s, with every
     second keyframe left out each time these are used up. A segment whose IMU samples do not fit any more ends early
     and is counted. 0 < least <= segment_s <= most <= 60; one 0: segment_s; both 0: all are of segment_s. */
  double least_segment_s, most_segment_s;
  int32_t keep_segments;  /* 1..SEGCAL_MAX_SEGMENTS; 0: 8, or the maximum if that is smaller */
  int32_t metric;         /* SEGCAL_METRIC_*; A, D and E judge each segment alone, SET_D all kept ones together */
  int32_t strategy;       /* SEGCAL_SINGLE_SESSION or SEGCAL_MULTI_SESSION */
  double least_gain_nats; /* a segment that tells less is never kept, [1e-9, 1e6]; 0: half a nat per parameter */
  double prior_sigma[SEGCAL_MAX_PARAMETERS]; /* [1e-9, 1e6]; 0: the defaults in docs/formats.md, "config.yaml" */
  double sigma_ref[SEGCAL_MAX_PARAMETERS];   /* normalises the metrics, [1e-9, 1e6]; 0: the prior's sigma */
  double filter_share; /* the filter estimates the calibration along its way; factor on the prior sigmas of these
                          estimates, [1e-6, 1]; 0: 1. 1e-3 holds it at what is given */
  uint64_t seed;       /* of the random metric */
  /* When the device begins a calibration of its own. All 0: when keep_segments are kept. Else as soon as the kept
     segments together predict all of these sigmas (before scaling by what the fit shows); once the database is full,
     parameters that it hardly shows (sigma above 0.5 of the prior's) are not waited for. Checked at each segment that
     is kept, once per session. It is done in the background and takes effect calibration_window ends of segments later,
     or at segcal_flush, segcal_new_session or segcal_calibrate; segments that end until then are counted as missed. */
  double trigger_sigma[SEGCAL_MAX_PARAMETERS]; /* of theta's entries, units as prior_sigma, [0, 1e6]; 0:
                                                  trigger_fraction's */
  double trigger_fraction; /* of each prior sigma, [0, 1), 0: no target but those above; -1: never of its own */
  int32_t joint_filter;    /* 1: no segments; the filter's own calibration is the result, for comparison. 0: off.
                              The filter estimates all of theta in either case, from priors of its own; what it
                              finds stays with it, and segcal_calibrate's result replaces it */
  /* Kept segments that newer ones contradict are dropped at calibration (a device that fell has another calibration).
     Probability that a calibration drops any although the device is the same, [1e-9, 0.1]; 0: 0.001; -1: never drop
     any. */
  double outdated_level;
  /* Effects that are estimated (SEGCAL_EFFECT_*), then further terms: together at most SEGCAL_MAX_EFFECT_ESTIMATES
     terms. They stand behind theta's other entries, effects by bit, and have entries of prior_sigma, sigma_ref,
     trigger_sigma. */
  uint32_t estimate_effects;
  int32_t n_terms;
  segcal_term_t term[SEGCAL_MAX_EFFECT_ESTIMATES + 1];
  double term_value[SEGCAL_MAX_EFFECT_ESTIMATES +
                    1]; /* start, and mean of the prior, of each estimated term, [-1e6, 1e6] */
  /* Effects that each scored segment is asked about, see segcal_get_effect_scores. Those that find no column any more
     (SEGCAL_MAX_EFFECT_COLUMNS) are refused. With any effect estimated or watched, segments whose states break their
     IMU links are kept up to ten times further: it may be the effect that breaks them. */
  uint32_t watch_effects;
  int32_t has_temperature; /* 1: segcal_imu_t.temperature is set; 0: it is not looked at */
  /* Drift of a corner along its track, beside pixel_sigma's white noise: a random walk per axis, px/sqrt(s), up to 100;
     0: none. A build without SEGCAL_TRACK_WALK refuses others. The filter takes this walk
     beside its own white noise: 1 px, with joint_filter pixel_sigma. */
  double track_walk;
  /* A calibration in the background takes effect at this end of a segment after its beginning, whenever it was done, up
     to 1000; 0: the fourth (16 s). One that is not done by then takes effect at the first end at which it is. With a
     window that the background keeps, the result does not depend on when it worked. */
  int32_t calibration_window;
  /* 1: segments that end once a calibration was released are condensed into epochs (SEGCAL_MAX_EPOCHS; a build without
     any refuses 1): the database stays as it is, and nothing that was seen is lost, until segments contradict what is
     known (segcal_get_change; needs two kept segments). 0: they compete for a place in the database. */
  int32_t condense;
} segcal_config_t;

/* ---- data in ---- */
typedef struct {
  int64_t t_ns;      /* IMU clock */
  float gyro[3];     /* rad/s, gyroscope's axes */
  float accel[3];    /* m/s^2, accelerometer's axes; at rest and level z reads +9.8 */
  float temperature; /* degC, with segcal_config_t.has_temperature; NaN, or outside [-200, 200]: as the sample before */
} segcal_imu_t;

typedef struct {
  uint32_t track_id; /* the same corner has the same number in all frames and cameras, different ones never */
  int32_t camera;    /* 0..n_cameras - 1 */
  float u, v; /* px, raw (distorted) image coordinates; outside [-1e6, 1e6], or not a number: the point is left out and
                 counted */
} segcal_point_t;

typedef struct {
  int64_t t_ns;
  double q_GI[4]; /* rotates I into G, w x y z */
  double p_GI[3]; /* m, [-1e9, 1e9] */
  double v_GI[3]; /* m/s, [-1e4, 1e4] */
  double b_a[3];  /* m/s^2, [-1e3, 1e3] */
  double b_g[3];  /* rad/s, [-100, 100] */
} segcal_state_t;

/* ---- results ---- */
enum { SEGCAL_INSUFFICIENT = 0, SEGCAL_CALIBRATED = 1, SEGCAL_FAILED = 2 };
enum { SEGCAL_FIXED = 0, SEGCAL_WEAK = 1, SEGCAL_OBSERVED = 2 };

typedef struct {
  char
      name[SEGCAL_NAME_LENGTH]; /* "cam0.r_CI.x" ... as in docs/formats.md, "result.json"; then "time_offset.t_d" ... */
  char unit[SEGCAL_UNIT_LENGTH]; /* "rad", "m", "px", "-", "s/row" ... */
  double value, initial;         /* rotations: the rotation vector's component */
  double sigma;                  /* scaled by what the fit shows */
  double prior_sigma;
  int32_t verdict; /* SEGCAL_OBSERVED, _WEAK, or _FIXED: stayed where it was */
} segcal_parameter_t;

typedef struct {
  double weight[SEGCAL_MAX_PARAMETERS]; /* in units of each parameter's prior sigma; the largest is 1 */
  double relative_sigma;                /* of the direction, in units of the prior's: near 1, nothing was learned */
} segcal_direction_t;

typedef struct {
  int32_t status; /* SEGCAL_CALIBRATED, _INSUFFICIENT, _FAILED */
  int32_t n_parameters;
  segcal_parameter_t parameter[SEGCAL_MAX_PARAMETERS];
  int32_t n_directions; /* directions that the kept segments do not excite */
  int32_t iterations, converged, segments, partitions, image_points;
  double chi2, dof;
  double noise_scale; /* sigmas are multiplied by this: square root of the largest of
                         1, chi2/dof, and how far segments disagree about the calibration */
  double reprojection_rms_px, reprojection_median_px;
} segcal_result_t;

typedef struct {
  int64_t start_ns, end_ns;
  uint32_t session, serial;
  int32_t keyframes, landmarks, points, rank;
  double A, D, E, gain_nats;
  int32_t kept;     /* at the time of the call */
  int32_t outdated; /* newer segments contradict it: the last calibration dropped it */
  int32_t settled;  /* its states follow its own IMU samples, at the calibration that the odometry believed; else it is
                       never kept */
} segcal_segment_t;

typedef struct {
  uint32_t imu_samples, imu_stamps_back, imu_gaps, imu_not_finite, imu_saturated;
  uint32_t frames, frames_used, frame_stamps_back, frames_dropped, frames_few_tracks, points_not_finite;
  uint32_t filter_restarts, standstill_frames, features_used, features_gated;
  uint32_t segments_closed, segments_discarded, segments_unsettled, segments_ended_early;
  uint32_t landmarks_left_out, points_left_out;
  uint32_t segments_outdated; /* dropped: contradicted by newer ones, or condensed before a calibration that failed */
  uint32_t segments_missed;   /* ended while a calibration was under way */
  uint32_t slices_late; /* times that a score, a calibration or the filter's start was due and segcal_background had not
                           done its slices: see there */
  uint32_t calibrations;    /* begun */
  uint32_t points_repeated; /* the same track twice in one image of one camera: the first point was taken */
  uint32_t imu_stamps_far; /* more than 1 s from the sample before: refused until the new time persists for 8 samples */
  uint32_t frame_stamps_far;       /* more than 2 s from the newest IMU sample: not of its clock, refused */
  uint32_t clock_restarts;         /* the IMU's clock was set back: the stream began anew */
  uint32_t calibrations_published; /* taken effect: segcal_get_result shows the last of them */
  uint32_t segments_late;          /* dropped: they ended while the segment before was still being scored */
  uint32_t imu_spikes; /* stood alone, or two in a row, far from the samples before and after: left out, and the open
                          segment ended. Not looked for below 100 Hz (two: 150 Hz) and in the first 20 samples after a
                          gap. Since segcal_create, not stored */
} segcal_counters_t;

enum { SEGCAL_WORK_NONE = 0, SEGCAL_WORK_START = 1, SEGCAL_WORK_SCORE = 2, SEGCAL_WORK_CALIBRATION = 3 };

typedef struct {
  int32_t work; /* SEGCAL_WORK_*: what segcal_background does next */
  int32_t
      ends_left; /* ends of segments until the calibration under way takes effect, if it is done by then; 0: none is */
  uint32_t done,
      expected;    /* slices that a score or calibration has had, and that the last of its kind took (0: none yet) */
  uint32_t slices; /* all, since segcal_create */
  uint32_t late;   /* segcal_counters_t.slices_late */
} segcal_progress_t;

/* Causes, the first that applies. */
enum {
  SEGCAL_HEALTH_RUNNING = 0,
  SEGCAL_HEALTH_NO_IMU = 1,         /* none, or none while frames go on */
  SEGCAL_HEALTH_IMU_REFUSED = 2,    /* more samples were refused than taken */
  SEGCAL_HEALTH_NO_FRAMES = 3,      /* none, or none for ten seconds of IMU samples */
  SEGCAL_HEALTH_CLOCKS_APART = 4,   /* most frames' stamps are more than 2 s from the IMU's */
  SEGCAL_HEALTH_FRAMES_REFUSED = 5, /* most frames' stamps do not grow */
  SEGCAL_HEALTH_FEW_TRACKS = 6,     /* most frames have too few points that go on */
  SEGCAL_HEALTH_STARTING = 7,       /* nothing is wrong yet: the filter collects frames */
  SEGCAL_HEALTH_FRAMES_TOO_FAR = 8, /* over 0.6 s apart, or too far for the IMU samples that the profile keeps: no
                                       start was tried */
  SEGCAL_HEALTH_NO_START = 9,       /* several starts were tried and none fits the motion */
  SEGCAL_HEALTH_LOST_OFTEN = 10,    /* the filter starts, and is lost again within ten seconds on average */
  SEGCAL_HEALTH_SATURATED = 11, /* most IMU samples are at full scale; or it runs, but more than one in a hundred is */
  SEGCAL_HEALTH_FRAMES_CROWDED = 12, /* does not run: most frames find no place to wait for their IMU samples, which
                                        come in long blocks */
  SEGCAL_HEALTH_SPIKES = 13, /* an IMU sample in four seconds, or more, stands alone or with one other, far from its
                                neighbours: they end segments */
  SEGCAL_HEALTH_STARTS_LATE = 14, /* does not run: starts in motion are due before segcal_background has done their
                                     slices */
  SEGCAL_HEALTH_IMU_RATE = 15,   /* IMU samples come at another rate than imu_rate_hz: most are a gap apart, or far more
                                    than stated */
  SEGCAL_HEALTH_NO_SEGMENTS = 16 /* runs, but of five segments or more none is of use: too few points, or far from the
                                    IMU's motion */
};

/* A whitened residual of the last calibration. */
typedef struct {
  int64_t t_ns;
  int32_t camera; /* 0.. for image points */
  /* predicted - measured in units of the pixel sigma; where tracks drift: what the points before of its track did not
     show, in units of the sigma of that */
  float u, v;
} segcal_point_residual_t;
typedef struct {
  int64_t t_ns;
  float rotation[3], velocity[3], position[3]; /* whitened, each with unit variance where the model holds */
} segcal_imu_residual_t;

/* ---- what a calibration was made from, for an independent check of it ---- */
typedef struct {
  double gyro_noise_density, gyro_random_walk, accel_noise_density, accel_random_walk;
  double gravity;                    /* m/s^2, along -z of G */
  double pixel_sigma;                /* px, per axis */
  double huber;                      /* whitened length of an image residual beyond which its cost grows linearly */
  double bias_a_sigma, bias_g_sigma; /* m/s^2, rad/s: prior about zero at the start of a chain of segments */
  double velocity_sigma;             /* m/s: prior about zero on the first keyframe of each segment */
  double inverse_depth_sigma;        /* 1/m: prior about zero on each landmark, from the camera that saw it first */
  double turned_inverse_depth_sigma; /* the same in a segment that only turned */
  double track_walk;                 /* px/sqrt(s), per axis: random walk of a corner's error along its track */
} segcal_model_t;

enum { SEGCAL_JOIN_NONE = 0, SEGCAL_JOIN_IMU = 1, SEGCAL_JOIN_BIAS = 2 };
typedef struct {
  int32_t place;       /* 0..: order in the last calibration; the segment before it has place - 1 */
  int32_t join;        /* SEGCAL_JOIN_*: starts a chain; follows by its IMU samples; only the bias walk links */
  double gap_s;        /* from the last keyframe of the segment before to the first one */
  int64_t lead_ns;     /* > 0: the samples begin this long before the first keyframe */
  int32_t turned_only; /* 1: its images show no translation: linearised as pure rotation, wide prior */
} segcal_link_t;

typedef struct {
  uint32_t track_id;
  int32_t tie;      /* landmarks of several segments with the same number are one; -1: the segment's own */
  double anchor[3]; /* m, in G; the landmark is at anchor + direction / inverse_distance */
  double direction[3];
  double inverse_distance; /* 1/m; about 0 without parallax */
} segcal_landmark_t;

typedef struct {
  int32_t landmark, keyframe; /* index in the segment */
  int32_t camera;
  int32_t rejected; /* 1: far off although the model fits, left out */
  float u, v;       /* px */
} segcal_measured_point_t;

/* An epoch: what segments that were condensed said about the calibration (segcal_config_t.condense). Values and sigmas
   are those that these segments and the prior give, without the kept segments and the other epochs; sigmas are scaled
   like the last release's, and wider where theta has left the calibration that they were condensed at. Order and units
   of segcal_result_t.parameter. */
typedef struct {
  int32_t segments;
  uint32_t first_session, last_session; /* from 0: sessions since segcal_create */
  int32_t n_parameters;
  double value[SEGCAL_MAX_PARAMETERS], sigma[SEGCAL_MAX_PARAMETERS];
  /* of segcal_get_history only: mean temperature, 25 without `has_temperature`; how many changes were decided before */
  double temperature_degC;
  int32_t changes;
} segcal_epoch_t;

/* Courses that the calibration may take over sessions. */
#define SEGCAL_COURSE_STEPS 1u       /* constant, but for decided changes (segcal_get_change) or one small step */
#define SEGCAL_COURSE_TREND 2u       /* linear in time, by the number of the session: ageing */
#define SEGCAL_COURSE_TEMPERATURE 4u /* linear in temperature (`has_temperature`; sessions must differ by 5 degC) */

/* How the calibration changed over the sessions that are remembered (segcal_get_history), as the last calibration
   found it. Where the decided changes do not explain what came, what it released is a mean over sessions, and its
   sigmas hold how far that is from the calibration of the last session, or at the temperature that is farthest. */
typedef struct {
  uint32_t courses; /* SEGCAL_COURSE_*: those that what came does not rule out, with odds of 20 to 1; 0: not asked, less
                       than three sessions or not calibrated */
  int32_t sessions;
  double ln_odds[3]; /* of steps, trend and temperature against the likeliest, up to 0; 1: not compared */
  /* One of SEGCAL_COURSE_*, the likeliest, of which `rate` is: of one block of parameters, 0 for the others. Of
     SEGCAL_COURSE_STEPS it is a step before `step_session` (from 0) that was too small to be noticed when it came. 0:
     the decided changes, or none, explain what came. */
  uint32_t rate_of, step_session;
  int32_t n_parameters;
  /* Per session, per degC, or the step, in the order and units of segcal_result_t.parameter; of a rotation, small
   * rotations, rad.
   */
  double rate[SEGCAL_MAX_PARAMETERS], sigma[SEGCAL_MAX_PARAMETERS];
} segcal_course_t;

/* A change of the device (segcal_config_t.condense): what was condensed and kept before was contradicted, and a release
 * dropped it. */
typedef struct {
  int32_t open; /* 1: not decided yet, too few segments came since: no steps, and sigmas of what was known */
  uint32_t before_session, after_session; /* of the segments on both sides, from 0; the same: within a session */
  int64_t t_ns;                           /* of the IMU's clock: where the segment begins that contradicted first */
  int32_t n_parameters;
  /* From what was known to the release, in the order and units of segcal_result_t.parameter; of a rotation, small
   * rotations, rad. */
  double step[SEGCAL_MAX_PARAMETERS], sigma[SEGCAL_MAX_PARAMETERS];
} segcal_change_t;

/* ---- functions ---- */
typedef struct segcal segcal_t;

/* The capacities of this header, for segcal_create_for: those of config.h that change the layout of any struct above or
   the meaning of a call. */
#define SEGCAL_N_CAPACITIES 18
#define SEGCAL_CAPACITIES                                                                                           \
  {                                                                                                                 \
    SEGCAL_MAX_CAMERAS, SEGCAL_MAX_SEGMENTS, SEGCAL_MAX_KEYFRAMES, SEGCAL_MAX_LANDMARKS, SEGCAL_MAX_OBSERVATIONS,   \
        SEGCAL_MAX_IMU_SAMPLES, SEGCAL_MAX_CLONES, SEGCAL_MAX_TRACKS, SEGCAL_FRAME_FEATURES, SEGCAL_START_DELAY_MS, \
        SEGCAL_WAITING_FRAMES, SEGCAL_MAX_TIES, SEGCAL_SHARED_LANDMARKS, SEGCAL_IMU_HISTORY,                        \
        SEGCAL_MAX_EFFECT_ESTIMATES, SEGCAL_MAX_EFFECT_COLUMNS, SEGCAL_PIXEL_BITS, SEGCAL_MAX_EPOCHS                \
  }

/* segcal_create for a caller that says what capacities it was compiled with (SEGCAL_N_CAPACITIES numbers): for other
 * languages. */
int segcal_create_for(segcal_t** device, const segcal_config_t* config, void* storage, size_t storage_bytes,
                      const uint32_t* capacities);
/* Puts a device into `storage` (any content) and points *device at it. Copies the configuration.
   SEGCAL_ERROR_CAPACITY: this file was compiled with other capacities than the library. */
static inline int segcal_create(segcal_t** device, const segcal_config_t* config, void* storage, size_t storage_bytes) {
  const uint32_t capacities[SEGCAL_N_CAPACITIES] = SEGCAL_CAPACITIES;
  return segcal_create_for(device, config, storage, storage_bytes, capacities);
}
/* Which capacity differs: "SEGCAL_MAX_CAMERAS: the program has 3, the library 2", into `line`; "" if none does. Returns
   1 if one differs, else 0. */
int segcal_explain_capacities(const uint32_t* capacities, char* line, size_t bytes);

/* One IMU sample; bounded time: no call that feeds does background work. A frame that waited for it is processed here.
 */
int segcal_push_imu(segcal_t* device, const segcal_imu_t* sample);
/* The points of one image (of all cameras, if there are several: same stamp). n <= SEGCAL_MAX_TRACKS per camera.
   Returns SEGCAL_TRACKING, SEGCAL_WAITING, SEGCAL_SKIPPED or SEGCAL_LOST, or an error. It waits (SEGCAL_WAITING) until
   the IMU samples of its time are there, and is processed in the segcal_push_imu that brings the last of them; where
   samples are averaged, since the IMU is faster than SEGCAL_MAX_IMU_SAMPLES allows, that is two averages later. Images
   for which they have not come at a segcal_flush stay out. */
int segcal_push_tracks(segcal_t* device, int64_t t_ns, const segcal_point_t* points, int32_t n);
/* Instead of segcal_push_tracks, for users with their own odometry: a keyframe's state and its points. The filter is
   not used. A segment needs four that see the same points, so they should come every segment_s / 4 or sooner. It waits
   for IMU samples as an image does; before the first of all samples it is skipped (SEGCAL_SKIPPED). */
int segcal_push_keyframe(segcal_t* device, const segcal_state_t* state, const segcal_point_t* points, int32_t n);
/* Does pending work, the filter's start in motion, the score of a segment that has ended or a calibration: at most
   `slices` slices, each bounded (docs/porting.md, section 5). Returns 1 while work is pending, else 0, or an error. As
   long as work is done when it is due, it changes no bit of what comes out how often this is called. Due is a score
   when the next segment ends, a calibration calibration_window ends later, a start SEGCAL_START_DELAY_MS after its
   frames (with 0 it is done at once and no background work). Work that is late is counted in slices_late, and nothing
   else of the state depends on when it was done: a score          the segment that ends is dropped (segments_late) a
   calibration    takes effect at the first end of a segment at which it is done a start          takes effect at the
   first frame at which it is done; if its samples are no longer there, a new one begins segcal_log_fed notes such
   moments, so that a replay repeats them. */
int segcal_background(segcal_t* device, int32_t slices);
/* 1: work that is due and not done is done at once, in the call that feeds, and nothing is ever late: for programs
   without deadlines, which then need no segcal_background. 0, as after segcal_create: as above. At any time. */
int segcal_work_when_due(segcal_t* device, int32_t on);
/* How far the background is. */
int segcal_progress(const segcal_t* device, segcal_progress_t* out);
/* A calibration from the kept segments, in the background: it begins when the next segment that ends has been scored,
   or in segcal_flush, and takes effect as one that the device begins of its own. With joint_filter: in segcal_flush
   only. Let go where segcal_calibrate does nothing. */
int segcal_request_calibration(segcal_t* device);
/* Ends the open segment now, scores it, and finishes all work that is pending, a calibration that was asked for
   included. Seconds of work on a microcontroller. */
int segcal_flush(segcal_t* device);
/* The same in bounded slices, at most `slices` of them: returns 1 while some are left, else 0. Nothing is to be fed in
   between. segcal_request_calibration(device); while (segcal_flush_slices(device, 8) == 1) feed_the_watchdog(); is
   segcal_flush and segcal_calibrate in slices; after it segcal_flush and segcal_new_session take the time of a slice.
 */
int segcal_flush_slices(segcal_t* device, int32_t slices);
/* Ends the session: as segcal_flush, then the filter starts again; the database is emptied if single session. */
int segcal_new_session(segcal_t* device);
/* Calibrates from the kept segments, at once: seconds of work on a microcontroller. Only a result that is `calibrated`
   moves theta and the filter. While a change is open and too few segments have come to decide (segcal_get_change):
   nothing, the last result stays. With none kept the result is `insufficient`, and every direction is named as not
   excited. With joint_filter: takes what the filter knows at this moment; a new session goes on from it, with all of
   its information. */
int segcal_calibrate(segcal_t* device);

int segcal_get_state(const segcal_t* device, segcal_state_t* state);
int segcal_get_camera(const segcal_t* device, int32_t camera, segcal_camera_t* out);
int segcal_get_imu_calibration(const segcal_t* device, segcal_imu_calibration_t* out);
int segcal_get_result(const segcal_t* device, segcal_result_t* result);
/* What the filter itself knows about the calibration at this moment: values, sigmas and verdicts by the same rule.
   Nothing about a fit. Before the filter's start: the prior. SEGCAL_ERROR_BUSY while a start in motion is under way. */
int segcal_get_filter_calibration(segcal_t* device, segcal_result_t* result);
/* The last result as a Gaussian over its parameters, for fusing several: `mean`, n numbers, where the fit has its
   optimum while nothing is held (segcal_parameter_t.value of what is FIXED stays at `initial`, and the others follow),
   and `covariance`, row-major, n x n, whose diagonal is the squares of the results' sigmas. Both contain the prior.
   What sigmas hold of a course (segcal_get_course) is on the diagonal alone: nothing is known of its correlations.
   `capacity` of covariance in numbers. Returns n; SEGCAL_ERROR_STATE without a result. */
int segcal_get_posterior(const segcal_t* device, double* mean, double* covariance, int32_t capacity);
/* Epoch `index`, 0: the oldest. SEGCAL_ERROR_STATE: there is none; SEGCAL_ERROR_BUSY: while work is pending. */
int segcal_get_epoch(segcal_t* device, int32_t index, segcal_epoch_t* out);
/* Change `index` of the last SEGCAL_MAX_EPOCHS, 0: the newest; -1: one that is open, while which calibrations wait
   until the database is full. SEGCAL_ERROR_STATE: there is none. */
int segcal_get_change(const segcal_t* device, int32_t index, segcal_change_t* out);
/* What session `index` of the last SEGCAL_MAX_HISTORY said that were condensed, 0: the oldest; also what a change has
   outdated since. Kept segments are not among them. Errors as of segcal_get_epoch. */
int segcal_get_history(segcal_t* device, int32_t index, segcal_epoch_t* out);
/* Steps, a trend, or temperature? SEGCAL_ERROR_STATE: no device, or a build without a history. */
int segcal_get_course(const segcal_t* device, segcal_course_t* out);
int segcal_get_direction(const segcal_t* device, int32_t index, segcal_direction_t* direction);
/* The segment scored last (index -1) or slot `index` of the database, 0..SEGCAL_MAX_SEGMENTS. SEGCAL_ERROR_STATE if
   empty. A slot whose segment was dropped as outdated answers, with `kept` 0, until a new segment needs it. */
int segcal_get_segment(const segcal_t* device, int32_t index, segcal_segment_t* segment);
/* Directions that the segment scored last does not excite: fills up to `capacity`, returns their number. */
int segcal_get_segment_directions(const segcal_t* device, segcal_direction_t* out, int32_t capacity);
/* Sigma of each parameter from the segment scored last and the prior, in the units of theta: fills up to `capacity`,
   returns their number. What sigma_ref is measured from. */
int segcal_get_segment_sigmas(const segcal_t* device, double* sigma, int32_t capacity);
int segcal_get_counters(const segcal_t* device, segcal_counters_t* counters);
/* What keeps the odometry from running at this moment, by what came since it used a frame the last time:
   SEGCAL_HEALTH_* (segcal/health.h has a sentence for each), or an error code. Work of a few dozen instructions: may be
   asked after every image. */
int segcal_get_health(const segcal_t* device);
/* Residuals of kept slot `index` after calibration; fill up to `capacity`, return their number. Before the first one
 * they tell nothing. */
int segcal_get_point_residuals(const segcal_t* device, int32_t index, segcal_point_residual_t* out, int32_t capacity);
int segcal_get_imu_residuals(const segcal_t* device, int32_t index, segcal_imu_residual_t* out, int32_t capacity);
/* Keyframe states of slot `index`. */
int segcal_get_keyframes(const segcal_t* device, int32_t index, segcal_state_t* out, int32_t capacity);
/* Landmarks, image points and stored IMU samples (rounded to 16 bits) of slot `index`; fill up to `capacity`, return
   their number. segcal_get_link: after a calibration that the slot took part in, SEGCAL_ERROR_STATE else. */
int segcal_get_landmarks(const segcal_t* device, int32_t index, segcal_landmark_t* out, int32_t capacity);
int segcal_get_points(const segcal_t* device, int32_t index, segcal_measured_point_t* out, int32_t capacity);
int segcal_get_samples(const segcal_t* device, int32_t index, segcal_imu_t* out, int32_t capacity);
int segcal_get_link(const segcal_t* device, int32_t index, segcal_link_t* out);
int segcal_get_model(const segcal_t* device, segcal_model_t* out);
/* One number over the bits of theta, its sigmas and verdicts, every state so far and the kept segments: devices and
   hosts that were fed the same and computed the same have the same one. 0 without a device. Reads all kept segments:
   not in bounded time like the calls above. */
uint64_t segcal_result_hash(const segcal_t* device);
/* Index 0..SEGCAL_EFFECTS - 1, by bit. SEGCAL_ERROR_SIZE beyond. */
int segcal_get_effect(int32_t index, segcal_effect_t* out);
/* Terms of an effect, up to SEGCAL_EFFECT_PARAMETERS of them; returns their number. */
int segcal_effect_terms(int32_t index, segcal_term_t* out);
/* Name ("gyro_x:fy*wz", or the catalogue's "time_offset.t_d"), unit and prior sigma of a term. */
int segcal_describe_term(const segcal_term_t* term, segcal_parameter_t* out);
/* Values of theta's terms, as segcal_get_camera gives the camera's: fill up to `capacity`, return their number. */
int segcal_get_terms(const segcal_t* device, segcal_term_t* term, double* value, int32_t capacity);

/* Score tests of the watched effects over all segments scored since the last calibration: would the effect, alone,
 * explain the residuals? Fills up to `capacity`, returns their number. The segments stand where the filter left them:
 * take a statistic far above its degrees of freedom times chi2_per_dof as a suspicion. */
typedef struct {
  int32_t effect;            /* index, as of segcal_get_effect */
  int32_t n_parameters, dof; /* dof: parameters that these segments can tell from theta */
  int32_t segments;
  double statistic;    /* chi-square with dof degrees of freedom if the effect is absent */
  double chi2_per_dof; /* of the residuals with all watched effects free */
  double estimate[SEGCAL_EFFECT_PARAMETERS], sigma[SEGCAL_EFFECT_PARAMETERS];
} segcal_effect_score_t;
int segcal_get_effect_scores(segcal_t* device, segcal_effect_score_t* out, int32_t capacity);

/* Square-root rows over [theta | candidates | residual] of the kept slots with use_slot[slot] != 0 (SEGCAL_MAX_SEGMENTS
 * + 1 entries), joined as a calibration joins them, everything else eliminated, linearised at the present states and
 * result and WITHOUT the prior on theta: the cost of these segments is |R delta - d|^2 + rho^2. `triangle`: packed
 * upper triangle, row-major, n = n_theta + n_terms + 1 columns, d last and rho in the corner; capacity in numbers, n (n
 * + 1) / 2 are written. Theta's entries are those of segcal_result_t, rotations as small rotations from the left.
 * n_candidates and theta's terms together at most SEGCAL_MAX_EFFECT_COLUMNS. dof: residuals minus states and landmarks,
 * theta and terms not counted. Call it after the segments were calibrated. It overwrites the workspace. Before the
 * first calibration, residuals and links are read from that workspace and change too. Takes as long as one step of a
 * calibration. */
int segcal_linearise(segcal_t* device, const uint8_t* use_slot, const segcal_term_t* candidate, int32_t n_candidates,
                     double* triangle, int32_t capacity, int32_t* n_theta, int32_t* n_terms, int32_t* dof);
/* Bytes of one database slot and of the workspaces. */
void segcal_memory(size_t* state_bytes, size_t* segment_bytes, size_t* workspace_bytes);

#ifdef __cplusplus
}
#endif
#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
#endif
