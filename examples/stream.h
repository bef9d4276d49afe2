/* A device that needs no files and no libm: a camera and an IMU, swung about in front of 40 corners. The example
 * programs feed it to segcal to see that they come to the same bits, however the library was built and linked. Readings
 * are whole steps of a sensor's converter, so that it does not matter what a compiler makes of the arithmetic here.
 * Replace it by your sensors. */
#ifndef STREAM_H
#define STREAM_H

#include <string.h>

#include "segcal/segcal.h"

enum { kCorners = 40, kRate = 200, kSamplesPerImage = 20, kSeconds = 12 };

typedef struct {
  double s[6], c[6];          /* sines and cosines of six swings: along and about x, y, z */
  double q[4];                /* rotates I into G */
  double corner[kCorners][3]; /* m, in G: ahead, left, up */
  double turn[3];             /* rad/s */
  uint32_t dice;
} stream_t;

static const double stream_half_step[6] = {0.0103, 0.0127, 0.0089,
                                           0.0137, 0.0109, 0.0119}; /* tangent of half a swing's angle in a sample */
static const double stream_size[6] = {0.25, 0.22, 0.28, 1.1, 1.3, 0.9}; /* m, rad/s */

/* The data sheet: the focal length and the centre are a little off. True are 300, 300, 320, 240. */
static void stream_config(segcal_config_t* config) {
  static const segcal_camera_t sheet = {
      SEGCAL_RADTAN, {0.5, 0.5, -0.5, 0.5}, {0, 0, 0}, {303, 303, 321, 239}, {0}, 480};
  memset(config, 0, sizeof *config);
  config->camera[0] = sheet;
}

/* From -1 to 1. */
static double stream_dice(stream_t* w) {
  w->dice = w->dice * 1664525u + 1013904223u;
  return (double)(w->dice >> 8) / 8388608 - 1;
}

static void stream_begin(stream_t* w) {
  memset(w, 0, sizeof *w);
  w->q[0] = 1;
  for (int i = 0; i < 6; ++i) w->c[i] = 1;
  for (int i = 0; i < kCorners * 3; ++i) {
    double* at = w->corner[i / 3];
    at[i % 3] = i % 3 == 0 ? 3 + 1.5 * stream_dice(w) : 0.5 * at[0] * stream_dice(w);
  }
}

/* Radians a second of a swing: its angle in a sample is 2 atan(half step). */
static double stream_pace(int i) {
  const double h = stream_half_step[i], h2 = h * h;
  return 2 * h * (1 - h2 / 3 + h2 * h2 / 5) * kRate;
}

/* v from I into G, or back. */
static void stream_rotate(const double q[4], int back, const double v[3], double out[3]) {
  const double x = back ? -q[1] : q[1], y = back ? -q[2] : q[2], z = back ? -q[3] : q[3];
  const double t[3] = {2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])};
  out[0] = v[0] + q[0] * t[0] + y * t[2] - z * t[1];
  out[1] = v[1] + q[0] * t[1] + z * t[0] - x * t[2];
  out[2] = v[2] + q[0] * t[2] + x * t[1] - y * t[0];
}

/* A period of the IMU later. */
static void stream_step(stream_t* w) {
  double half[3], length = 0;
  for (int i = 0; i < 6; ++i) {
    const double h = stream_half_step[i], c = (1 - h * h) / (1 + h * h), s = 2 * h / (1 + h * h), was = w->s[i];
    w->s[i] = was * c + w->c[i] * s;
    w->c[i] = w->c[i] * c - was * s;
  }
  for (int i = 0; i < 3; ++i) {
    const double turn = stream_size[3 + i] * w->c[3 + i];
    half[i] = (w->turn[i] + turn) / (4 * kRate); /* half the angle of this period */
    w->turn[i] = turn;
  }
  const double a = w->q[0], x = w->q[1], y = w->q[2], z = w->q[3];
  w->q[0] = a - x * half[0] - y * half[1] - z * half[2];
  w->q[1] = x + a * half[0] + y * half[2] - z * half[1];
  w->q[2] = y + a * half[1] + z * half[0] - x * half[2];
  w->q[3] = z + a * half[2] + x * half[1] - y * half[0];
  for (int i = 0; i < 4; ++i) length += w->q[i] * w->q[i];
  for (int i = 0; i < 4; ++i) w->q[i] *= (3 - length) / 2; /* nearly 1: this is 1 / sqrt */
}

/* Whole steps, as from a converter. */
static float stream_steps(double value, double step) {
  const double n = value / step;
  return (float)(int32_t)(n < 0 ? n - 0.5 : n + 0.5) * (float)step;
}

static segcal_imu_t stream_sample(stream_t* w, int64_t t_ns) {
  segcal_imu_t out = {0};
  double force[3], inside[3];
  for (int i = 0; i < 3; ++i)
    force[i] = -stream_size[i] * stream_pace(i) * stream_pace(i) * w->s[i] + (i == 2 ? 9.80665 : 0);
  stream_rotate(w->q, 1, force, inside);
  out.t_ns = t_ns;
  for (int i = 0; i < 3; ++i) {
    out.gyro[i] = stream_steps(w->turn[i] + 0.004 * stream_dice(w), 1.0 / 1024);
    out.accel[i] = stream_steps(inside[i] + 0.05 * stream_dice(w), 1.0 / 256);
  }
  return out;
}

/* The corners that this pose sees; returns their number. */
static int stream_image(stream_t* w, segcal_point_t points[kCorners]) {
  int n = 0;
  for (int k = 0; k < kCorners; ++k) {
    double from[3], p[3];
    for (int i = 0; i < 3; ++i) from[i] = w->corner[k][i] - stream_size[i] * w->s[i];
    stream_rotate(w->q, 1, from, p);
    const double u = 320 - 300 * p[1] / p[0], v = 240 - 300 * p[2] / p[0];
    if (p[0] < 0.1 || u < 0 || u >= 640 || v < 0 || v >= 480) continue;
    points[n].track_id = (uint32_t)k + 1;
    points[n].camera = 0;
    points[n].u =
        stream_steps(u + 0.87 * stream_dice(w), 1.0 / 16); /* a sigma of 0.5 px, segcal's default; so the others */
    points[n++].v = stream_steps(v + 0.87 * stream_dice(w), 1.0 / 16);
  }
  return n;
}

/* Feeds all of it, calibrates, and returns the number that stands for every bit of what came out; 0: nothing was
 * calibrated. */
static uint64_t stream_hash(segcal_t* device) {
  static stream_t world;
  static segcal_point_t points[kCorners];
  int calibrated = 0;
  stream_begin(&world);
  for (int i = 1; i <= kSeconds * kRate; ++i) {
    const int64_t t_ns = INT64_C(1000000000) * i / kRate;
    stream_step(&world);
    const segcal_imu_t sample = stream_sample(&world, t_ns);
    segcal_push_imu(device, &sample);
    if (i % kSamplesPerImage == 0) segcal_push_tracks(device, t_ns, points, stream_image(&world, points));
    while (segcal_background(device, 100) == 1) {
    }
  }
  segcal_flush(device);
  calibrated = segcal_calibrate(device) == SEGCAL_OK;
  return calibrated ? segcal_result_hash(device) : 0;
}

#endif
