/* feed IMU.csv TRACKS.csv: calibrates the camera and IMU that made these two files of a recording. */
#include <inttypes.h>
#include <stdio.h>

#include "segcal/segcal.h"

/* All the memory that the library ever uses; and a configuration of zeroes, which means defaults. */
static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config;
static segcal_result_t result;

int main(int argc, char** argv) {
  const segcal_camera_t data_sheet = {
      SEGCAL_FOV, {0.4569, 0.5168, -0.5218, 0.5018}, {0.057, -0.015, -0.034}, {256, 256, 319.5, 239.5}, {0.92}, 480};
  const char* const verdict[] = {"fixed", "weak", "observed"};
  FILE *imu = argc == 3 ? fopen(argv[1], "r") : NULL, *tracks = argc == 3 ? fopen(argv[2], "r") : NULL;
  segcal_t* device;
  segcal_imu_t s = {0};
  segcal_point_t p = {0}, image[SEGCAL_MAX_TRACKS];
  int64_t image_ns = 0, row_ns = 0;
  config.camera[0] = data_sheet;
  if (!imu || !tracks || segcal_create(&device, &config, memory, sizeof memory) != SEGCAL_OK) return 2;
  if (fscanf(imu, "%*[^\n]") + fscanf(tracks, "%*[^\n]") != 0) return 2; /* the headers */
  for (int n = 0, row = 4; row == 4; image_ns = row_ns) {
    row = fscanf(tracks, "%" SCNd64 ",%" SCNu32 ",%f,%f", &row_ns, &p.track_id, &p.u, &p.v);
    /* When an image is complete: first the IMU up to it, then its points. */
    if (n > 0 && (row != 4 || row_ns != image_ns)) {
      while (s.t_ns < image_ns && fscanf(imu, "%" SCNd64 ",%f,%f,%f,%f,%f,%f", &s.t_ns, &s.gyro[0], &s.gyro[1],
                                         &s.gyro[2], &s.accel[0], &s.accel[1], &s.accel[2]) == 7)
        segcal_push_imu(device, &s);
      segcal_push_tracks(device, image_ns, image, n);
      while (segcal_background(device, 100) == 1) continue; /* in firmware: a task of low priority */
      n = 0;
    }
    if (n < SEGCAL_MAX_TRACKS) image[n++] = p;
  }
  segcal_flush(device); /* ends and scores the segment that is being built */
  const int answer = segcal_calibrate(device);
  if (segcal_get_result(device, &result) != SEGCAL_OK) return 1; /* no segment told enough to be kept */
  for (const segcal_parameter_t* q = result.parameter; q < result.parameter + result.n_parameters; ++q)
    printf("%-14s %12.6f +- %.6f %-4s %s\n", q->name, q->value, q->sigma, q->unit, verdict[q->verdict]);
  return answer == SEGCAL_OK ? 0 : 1;
}
