/* firmware_loop IMU.csv TRACKS.csv: segcal in two threads, as a firmware has it, on the two files of examples/feed.c.
 * It prints the table that feed prints: as long as the background thread keeps up, it changes no bit when and how often
 * it works.
 *
 * POSIX threads stand for the RTOS; Zephyr and ESP-IDF have them too. With FreeRTOS' own names: xSemaphoreCreateMutex
 * for the lock, a task notification for the wake-up.
 *
 *   sensor thread, high priority        takes samples and tracks from the drivers' queues, pushes them
 *   background thread, lowest priority  scores segments, calibrates, hands a new calibration to the application
 */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdio.h>
#include <time.h>

#include "segcal/segcal.h"

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config; /* large structs are static: stacks are small */
static segcal_result_t latest; /* what the application uses; written and read under the lock */
static segcal_t* device;

/* One lock for every call on the device, the getters too: segcal takes none itself. The sensor thread waits for it no
 * longer than one slice of background work takes (slice_max in build/firmware/budget.md), since the background thread
 * lets go after each. The mutex must have priority inheritance, or a thread of middle priority that interrupts a slice
 * stops the sensor thread as well. An interrupt handler cannot wait for a lock: it puts its sample into a queue, and
 * the sensor thread pushes it. */
static pthread_mutex_t lock;
static sem_t new_frame; /* wakes the background thread */
static int pending;     /* under the lock: the background thread has something to do */
static int ended;       /* under the lock */

static void on_new_calibration(void) { /* with the lock held: copy, and use the copy later */
  segcal_get_result(device, &latest);
}

static void* background_thread(void* unused) {
  static segcal_counters_t counters;
  uint32_t published = 0;
  for (int stop = 0; !stop;) {
    int more = 1;
    sem_wait(&new_frame); /* sleeps until there may be work */
    while (more) {
      pthread_mutex_lock(&lock);
      more = pending = segcal_background(device, 1) == 1; /* one slice; 1: more is left */
      segcal_get_counters(device, &counters);
      if (counters.calibrations_published != published) on_new_calibration();
      published = counters.calibrations_published;
      stop = ended;
      pthread_mutex_unlock(&lock); /* after each slice: the sensor thread comes first */
    }
  }
  return unused;
}

/* A file has no pace of its own, which leaves the background thread its time: what is read next waits until that is
 * done. */
static void wait_for_background(void) {
  const struct timespec a_millisecond = {0, 1000000};
  for (int busy = 1; busy;) {
    pthread_mutex_lock(&lock);
    busy = pending;
    pthread_mutex_unlock(&lock);
    if (busy) nanosleep(&a_millisecond, NULL);
  }
}

/* In firmware: waits for the drivers' queues. Here: reads from the file. 0: the data have ended. */
static int next_image(FILE* tracks, int64_t* t_ns, segcal_point_t* image, int* n) {
  static segcal_point_t p;
  static int64_t row_ns;
  static int row = 0;
  if (row == 0) row = fscanf(tracks, "%" SCNd64 ",%" SCNu32 ",%f,%f", &row_ns, &p.track_id, &p.u, &p.v);
  *t_ns = row_ns;
  for (*n = 0; row == 4 && row_ns == *t_ns;) {
    if (*n < SEGCAL_MAX_TRACKS) image[(*n)++] = p;
    row = fscanf(tracks, "%" SCNd64 ",%" SCNu32 ",%f,%f", &row_ns, &p.track_id, &p.u, &p.v);
  }
  wait_for_background();
  return *n > 0;
}

static void sensor_loop(FILE* imu, FILE* tracks) {
  static segcal_point_t image[SEGCAL_MAX_TRACKS];
  segcal_imu_t s = {0};
  int64_t t_ns;
  for (int n; next_image(tracks, &t_ns, image, &n);) {
    while (s.t_ns < t_ns && fscanf(imu, "%" SCNd64 ",%f,%f,%f,%f,%f,%f", &s.t_ns, &s.gyro[0], &s.gyro[1], &s.gyro[2],
                                   &s.accel[0], &s.accel[1], &s.accel[2]) == 7) {
      pthread_mutex_lock(&lock); /* for each sample anew: a sample that waits for a whole block of them is late */
      segcal_push_imu(device, &s);
      pthread_mutex_unlock(&lock);
    }
    pthread_mutex_lock(&lock);
    segcal_push_tracks(device, t_ns, image, n);
    pending = 1;
    pthread_mutex_unlock(&lock);
    sem_post(&new_frame);
  }
}

int main(int argc, char** argv) {
  const segcal_camera_t data_sheet = {
      SEGCAL_FOV, {0.4569, 0.5168, -0.5218, 0.5018}, {0.057, -0.015, -0.034}, {256, 256, 319.5, 239.5}, {0.92}, 480};
  const char* const verdict[] = {"fixed", "weak", "observed"};
  FILE *imu = argc == 3 ? fopen(argv[1], "r") : NULL, *tracks = argc == 3 ? fopen(argv[2], "r") : NULL;
  static segcal_counters_t counters;
  pthread_mutexattr_t inherit;
  pthread_t background;
  config.camera[0] = data_sheet;
  if (!imu || !tracks || segcal_create(&device, &config, memory, sizeof memory) != SEGCAL_OK) return 2;
  if (fscanf(imu, "%*[^\n]") + fscanf(tracks, "%*[^\n]") != 0) return 2; /* the headers */
  segcal_work_when_due(device, 1); /* a busy PC has no deadlines. Firmware leaves this out: see segcal_background */
  if (pthread_mutexattr_init(&inherit) || pthread_mutexattr_setprotocol(&inherit, PTHREAD_PRIO_INHERIT) ||
      pthread_mutex_init(&lock, &inherit) || sem_init(&new_frame, 0, 0))
    return 2;
  if (pthread_create(&background, NULL, background_thread, NULL)) return 2;
  sensor_loop(imu, tracks); /* a device runs for ever; the rest is for the end of a file */
  pthread_mutex_lock(&lock);
  ended = 1;
  pthread_mutex_unlock(&lock);
  sem_post(&new_frame);
  pthread_join(background, NULL);
  segcal_flush(device);
  segcal_calibrate(device); /* from the segments since the last one that the device began itself, and those before */
  on_new_calibration();
  for (const segcal_parameter_t* q = latest.parameter; q < latest.parameter + latest.n_parameters; ++q)
    printf("%-14s %12.6f +- %.6f %-4s %s\n", q->name, q->value, q->sigma, q->unit, verdict[q->verdict]);
  segcal_get_counters(device, &counters);
  fprintf(stderr, "%" PRIu32 " calibrations, %" PRIu32 " pieces of work were late\n", counters.calibrations,
          counters.slices_late);
  return latest.status == SEGCAL_CALIBRATED ? 0 : 1;
}
