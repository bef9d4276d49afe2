/* drawn_device RATE START IMU.csv CAM0.csv [CAM1.csv]: calibrates from a simulated recording and prints everything that
 * a device says of it, as "word value..." lines. START has a line for each camera: q_CI, p_CI, intrinsics, distortion.
 * Keeps as many segments as there is room for. Exit code 0: there was a device, whatever came of it; 3: segcal_create
 * refused. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "segcal/health.h"
#include "segcal/lookup.h"

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config;
static segcal_result_t result;
static segcal_counters_t counters;
static segcal_point_t image[SEGCAL_MAX_CAMERAS * SEGCAL_MAX_TRACKS];

/* The rows of a camera's file, one ahead. */
typedef struct {
  FILE* file;
  int64_t t_ns;
  segcal_point_t p;
} tracks_t;

static void next_row(tracks_t* t) {
  if (fscanf(t->file, "%" SCNd64 ",%" SCNu32 ",%f,%f", &t->t_ns, &t->p.track_id, &t->p.u, &t->p.v) != 4)
    t->t_ns = INT64_MAX;
}

static FILE* open_csv(const char* name) {
  FILE* file = fopen(name, "r");
  if (!file || fscanf(file, "%*[^\n]") != 0) exit(2);
  return file;
}

static void read_start(const char* name) {
  FILE* file = fopen(name, "r");
  for (int c = 0; c < config.n_cameras; ++c) {
    segcal_camera_t* k = &config.camera[c];
    double* const part[] = {k->q_CI, k->p_CI, k->intrinsics, k->distortion};
    const int length[] = {4, 3, 4, 4};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < length[i]; ++j)
        if (!file || fscanf(file, "%lf", &part[i][j]) != 1) exit(2);
    k->model = SEGCAL_FOV;
    k->height = 480;
  }
  fclose(file);
}

/* All cameras' points of one stamp; the oldest tracks stand first in the files. Returns their number. */
static int next_image(tracks_t* camera, int64_t* t_ns) {
  int n = 0;
  *t_ns = INT64_MAX;
  for (int c = 0; c < config.n_cameras; ++c)
    if (camera[c].t_ns < *t_ns) *t_ns = camera[c].t_ns;
  for (int c = 0; c < config.n_cameras && *t_ns != INT64_MAX; ++c)
    for (int taken = 0; camera[c].t_ns == *t_ns; next_row(&camera[c]))
      if (taken++ < SEGCAL_MAX_TRACKS) {
        image[n] = camera[c].p;
        image[n++].camera = c;
      }
  return n;
}

static void print(const segcal_t* device, int answer) {
  const segcal_counters_t* c = &counters;
  const int health = segcal_get_health(device), none = segcal_get_result(device, &result) != SEGCAL_OK;
  segcal_get_counters(device, &counters);
  printf("health %d %s\nanswer %d %s\n", health, segcal_health_words(health), answer, segcal_code_words(answer));
  printf("frames %" PRIu32 "\nframes_used %" PRIu32 "\nrestarts %" PRIu32 "\nclosed %" PRIu32 "\ndiscarded %" PRIu32
         "\nunsettled %" PRIu32 "\nended_early %" PRIu32 "\nlandmarks_left_out %" PRIu32 "\npoints_left_out %" PRIu32
         "\nlate %" PRIu32 "\n",
         c->frames, c->frames_used, c->filter_restarts, c->segments_closed, c->segments_discarded,
         c->segments_unsettled, c->segments_ended_early, c->landmarks_left_out, c->points_left_out, c->slices_late);
  size_t state, segment, workspace;
  segcal_memory(&state, &segment, &workspace);
  printf("bytes %zu\nsegment_bytes %zu\nstatus %d\n", segcal_storage_bytes(), segment, none ? -1 : result.status);
  if (none) return;
  printf("segments %" PRId32 "\ndirections %" PRId32 "\nnoise_scale %.3f\nchi2_per_dof %.3f\n", result.segments,
         result.n_directions, result.noise_scale, result.chi2 / result.dof);
  for (const segcal_parameter_t* p = result.parameter; p < result.parameter + result.n_parameters; ++p)
    printf("parameter %s %.12g %.6g %" PRId32 "\n", p->name, p->value, p->sigma, p->verdict);
}

int main(int argc, char** argv) {
  tracks_t camera[SEGCAL_MAX_CAMERAS];
  segcal_imu_t s = {0};
  segcal_t* device;
  if (argc < 5 || argc - 4 > SEGCAL_MAX_CAMERAS) return 2;
  FILE* imu = open_csv(argv[3]);
  config.n_cameras = argc - 4;
  config.imu_rate_hz = atof(argv[1]);
  config.keep_segments = SEGCAL_MAX_SEGMENTS;
  read_start(argv[2]);
  for (int c = 0; c < config.n_cameras; ++c) {
    camera[c].file = open_csv(argv[4 + c]);
    next_row(&camera[c]);
  }
  const int code = segcal_create(&device, &config, memory, sizeof memory);
  if (code != SEGCAL_OK) {
    printf("refused %d %s\n", code, segcal_code_words(code));
    return 3;
  }
  int64_t t_ns;
  for (int n = next_image(camera, &t_ns); n > 0; n = next_image(camera, &t_ns)) {
    while (s.t_ns < t_ns && fscanf(imu, "%" SCNd64 ",%f,%f,%f,%f,%f,%f", &s.t_ns, &s.gyro[0], &s.gyro[1], &s.gyro[2],
                                   &s.accel[0], &s.accel[1], &s.accel[2]) == 7)
      segcal_push_imu(device, &s);
    segcal_push_tracks(device, t_ns, image, n);
    while (segcal_background(device, 100) == 1) {
    }
  }
  segcal_flush(device);
  print(device, segcal_calibrate(device));
  return 0;
}
