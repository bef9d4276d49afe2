/* A device log: what a device was fed, in order, with all bits, so that a host repeats what it computed.
 *
 * Layout in docs/formats.md. No heap and no waiting: samples gather in a block of the caller's and go out through the
 * caller's function when the block is full or another kind of data comes. Call the function here first, then the one of
 * segcal.h that it stands for:
 *
 *     segcal_log_begin(&log, &config, block, sizeof block, write, context);
 *     segcal_create(&device, &config, ...);
 *
 *     segcal_log_imu(&log, &sample);
 *     segcal_push_imu(device, &sample);
 *     segcal_log_fed(&log, device);
 *
 *     segcal_log_tracks(&log, t_ns, points, n);
 *     segcal_push_tracks(device, t_ns, points, n);
 *     segcal_log_fed(&log, device);
 *
 *     segcal_log_mark(&log, SEGCAL_LOG_CALIBRATE);
 *     segcal_calibrate(device);
 *     segcal_log_hash(&log, segcal_result_hash(device));
 *     segcal_log_end(&log);
 *
 * A log need not begin at segcal_create: where a session ends, and after segcal_restore, it may begin with the device's
 * state, and logs rotate. The state goes in before anything is fed, through the store (link segcal_store, and
 * include segcal/store.h), for which the log is a flash. Meanwhile the device must not be fed:
 *
 *     segcal_flush(device);  ...
 *     segcal_log_end(&log);
 *     segcal_new_session(device);     the state is that of a session's beginning: no mark in either log
 *     segcal_log_begin(&log, &config, block, sizeof block, write, next_file);
 *     segcal_log_state(&log, device, &flash);
 *     segcal_store_open(&store, &flash);    while (segcal_store_work(&store, 16) == 1) other_things();
 *     segcal_save(&store, device);          while ((answer = segcal_store_work(&store, 16)) == 1) other_things();
 *
 * Until the save has answered 0, all calls of the log that follow answer SEGCAL_ERROR_STATE; with another answer begin
 * the log again. Such a log replays alone, or behind the one before it, to the device's bits. What was asked for and
 * has not begun (segcal_request_calibration) is not in a state: ask after the save. A device with joint_filter has no
 * state that could be saved (SEGCAL_ERROR_CONFIG).
 *
 * segcal_background needs no mark: it changes when work is done. What was not done when it was due, segcal_log_fed
 * notes after the call that found it so. A flush in slices is marked as one when it begins. Keyframes of the user's own
 * odometry have no place in a log.
 */
#ifndef SEGCAL_LOG_H
#define SEGCAL_LOG_H

#include "segcal/segcal.h"
#include "segcal/store.h"

#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif
#ifdef __cplusplus
extern "C" {
#endif

#define SEGCAL_LOG_FORMAT 2u

/* Bytes of the block that hold any configuration and any frame. A larger block means fewer and longer writes. */
#define SEGCAL_LOG_TRACKS_BYTES (12u + 13u * SEGCAL_MAX_TRACKS * SEGCAL_MAX_CAMERAS)
#define SEGCAL_LOG_BLOCK_BYTES \
  (32u + (sizeof(segcal_config_t) > SEGCAL_LOG_TRACKS_BYTES ? sizeof(segcal_config_t) : SEGCAL_LOG_TRACKS_BYTES))

/* Calls that have no data of their own. */
enum {
  SEGCAL_LOG_NEW_SESSION = 1,
  SEGCAL_LOG_FLUSH = 2,
  SEGCAL_LOG_CALIBRATE = 3,
  SEGCAL_LOG_REQUEST_CALIBRATION = 4,
  SEGCAL_LOG_LATE = 5 /* the call that fed last found work late: segcal_log_fed writes it */
};

/* Appends bytes to the file; 0 if they are all written. */
typedef int (*segcal_log_write_t)(void* context, const void* bytes, size_t n);

/* The writer. Its fields are its own. */
typedef struct {
  segcal_log_write_t write;
  void* context;
  uint8_t* block;
  size_t capacity, used;                        /* bytes of the block */
  int64_t t0_ns;                                /* of the first sample in the block */
  uint32_t samples;                             /* in the block */
  uint32_t sequence;                            /* of the next block */
  uint32_t late;                                /* segcal_progress_t.late that the log has so far */
  uint32_t page_block, page_offset, page_bytes; /* of the device's state: what the block has of it */
  uint32_t syncs;                               /* of the save under way: 2 when its state is whole */
  int32_t awaits_state;                         /* 1: a state was announced and is not whole: no call may come */
  int32_t fed;                                  /* 1: the log has calls, behind which a state would come too late */
  int32_t failed; /* 1: the caller's function refused a block; nothing is written any more */
} segcal_log_t;

/* Starts a log: header and configuration. SEGCAL_ERROR_SIZE if the block is smaller than SEGCAL_LOG_BLOCK_BYTES.
   All functions return SEGCAL_ERROR_STATE if the caller's function refused, now or earlier. */
int segcal_log_begin(segcal_log_t* log, const segcal_config_t* config, uint8_t* block, size_t block_bytes,
                     segcal_log_write_t write, void* context);
/* The flash by which the log takes the state of `device`, and of no other, which was not fed since it was created,
   restored, or began a session; see above. SEGCAL_ERROR_STATE if its odometry runs, or if the log has calls. `log` and
   its block must stay. It is for one save: each page goes into the log and is read back from the block; all else reads
   as erased. */
int segcal_log_state(segcal_log_t* log, const segcal_t* device, segcal_flash_t* flash);
int segcal_log_imu(segcal_log_t* log, const segcal_imu_t* sample);
int segcal_log_tracks(segcal_log_t* log, int64_t t_ns, const segcal_point_t* points, int32_t n);
int segcal_log_mark(segcal_log_t* log, int32_t mark);
/* After each call that feeds: whether it found work that was due and not done. Writes nothing if not. */
int segcal_log_fed(segcal_log_t* log, const segcal_t* device);
/* segcal_result_hash() at this place: `segcal replay --verify-hash` computes it again. */
int segcal_log_hash(segcal_log_t* log, uint64_t hash);
/* Writes out what still waits in the block. Call it from time to time: a power failure loses what waits. */
int segcal_log_sync(segcal_log_t* log);
/* The log is whole: a reader need not suspect that something is missing. */
int segcal_log_end(segcal_log_t* log);

#ifdef __cplusplus
}
#endif
#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
#endif
