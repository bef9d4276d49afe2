/* A memory that outlives power: kept segments, theta, and the last calibration, in a few erase blocks of flash.
 *
 * docs/storage.md says every byte and why a power cut at any moment leaves the old state or the new one, whole. No
 * heap: the store is one small struct of the caller's. Nothing waits: each call of segcal_store_work does a bounded
 * number of slices, and a slice is at most one erasure of a block, one program of SEGCAL_STORE_PAGE_MAX bytes read
 * back, one read of as many, or one sync. Link the library segcal_store beside segcal.
 *
 *     segcal_store_open(&store, &flash);      while (segcal_store_work(&store, 16) == 1) other_things();
 *     segcal_restore(&store, device);         while ((answer = segcal_store_work(&store, 16)) == 1) other_things();
 *     ...                                     feed a session
 *     segcal_new_session(device);
 *     segcal_save(&store, device);            while ((answer = segcal_store_work(&store, 16)) == 1) other_things();
 */
#ifndef SEGCAL_STORE_H
#define SEGCAL_STORE_H

#include "segcal/segcal.h"

#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif
#ifdef __cplusplus
extern "C" {
#endif

/* Of the stored bytes; not the library's. A store of a newer major format is refused, all of a newer minor one is
 * readable. */
#define SEGCAL_STORE_MAJOR 1u
#define SEGCAL_STORE_MINOR 3u

/* ---- what the platform gives ---- */
/* A function's answer: 0 done; SEGCAL_FLASH_BAD: this block, or what is read, is unusable, others may be well; anything
   else: the medium cannot be reached, and the call that needed it fails. */
enum { SEGCAL_FLASH_BAD = 1 };

typedef struct {
  void* context;
  uint32_t
      program_bytes; /* smallest unit that is programmed, a power of two, 1..256; offsets and lengths are multiples */
  uint32_t erase_bytes; /* of a block; a multiple of SEGCAL_STORE_PAGE_MAX, 512..16 MiB */
  uint32_t blocks;      /* 2..65535 */
  /* Bytes of a block as they are. Erased ones read 0xFF. */
  int (*read)(void* context, uint32_t block, uint32_t offset, void* to, uint32_t n);
  /* Erased bytes, each once between two erasures. May be reordered, torn and lost by a power cut until sync returned.
   */
  int (*program)(void* context, uint32_t block, uint32_t offset, const void* from, uint32_t n);
  int (*erase)(void* context, uint32_t block);
  /* Returns when all that was programmed and erased is on the medium. */
  int (*sync)(void* context);
} segcal_flash_t;

#define SEGCAL_STORE_PAGE_MAX 256

/* ---- the store: its memory is its own. It holds no address of the device's inside between two calls of
   segcal_store_work that answered 0. ---- */
#define SEGCAL_STORE_WORDS 112
typedef struct {
  uint64_t memory[SEGCAL_STORE_WORDS];
} segcal_store_t;

typedef struct {
  int32_t ready;       /* 1: opened, nothing under way */
  uint32_t generation; /* of the newest whole state: grows with each save; 0: nothing is stored */
  uint32_t blocks;     /* that it takes, unusable ones between them included */
  uint32_t
      passed_over;     /* newer states that were not whole, when it was last looked for: interrupted saves, or damage */
  uint32_t bad_blocks; /* skipped since the store was opened: the port refused them, or they did not read back as
                          programmed */
  uint32_t erases, programs;                            /* since the store was opened */
  uint32_t library_version, format_major, format_minor; /* that wrote the newest whole state; after
                                                           SEGCAL_ERROR_VERSION: what is stored and cannot be read */
} segcal_store_info_t;

/* Begins to look for the newest whole state; the struct is copied, what its context points to must stay.
   SEGCAL_ERROR_SIZE: numbers out of range. */
int segcal_store_open(segcal_store_t* store, const segcal_flash_t* flash);
/* Goes on with what was begun, at most `pieces` slices. 1: not done; then 0 or SEGCAL_EMPTY, once, or an error, with
   which it has ended: SEGCAL_EMPTY           restore: nothing is stored; the device is as created SEGCAL_ERROR_STORAGE
   the medium failed; what was stored stays SEGCAL_ERROR_FULL      save: the good blocks beside the newest whole state
   are too few; that state stays SEGCAL_ERROR_VERSION   stored by a newer major format: nothing is read, and nothing
   overwritten SEGCAL_ERROR_CONFIG    restore: stored with another configuration; SEGCAL_ERROR_CAPACITY: with other
   capacities; segcal_store_difference names it; the device is as created SEGCAL_ERROR_BUSY      save: the device
   changed meanwhile what was being saved; what was stored before stays SEGCAL_ERROR_STATE     nothing was begun */
int segcal_store_work(segcal_store_t* store, int32_t pieces);
int segcal_store_get_info(const segcal_store_t* store, segcal_store_info_t* info);
/* After SEGCAL_ERROR_CONFIG or _CAPACITY of a restore: the first field that differs, "imu_rate_hz" or the like; else
 * "". */
const char* segcal_store_difference(const segcal_store_t* store);
/* Good blocks of such flash that are always enough for these capacities: two states, each at its largest. 0: numbers
   out of range. More of them wear less each. */
uint32_t segcal_store_blocks(const segcal_flash_t* flash);

/* Begins to save the device as segcal_flush, segcal_new_session or segcal_calibrate left it: the kept segments, theta,
   the last report, the counters. It may be fed meanwhile; if a segment ends or a calibration begins before all is
   written, segcal_store_work answers SEGCAL_ERROR_BUSY. So does this call unless all of the device's work is done.
   SEGCAL_ERROR_CONFIG with joint_filter, whose information is the filter's and is not stored. Neither device nor store
   may move before segcal_store_work is done. */
int segcal_save(segcal_store_t* store, segcal_t* device);
/* Begins to restore what was saved last, into a device that was created with the same configuration and has not been
   fed. When segcal_store_work answers 0, the device goes on as if segcal_new_session had been called where the save was
   made (or was called: a save right after it is the same): the same data bring the same bits, at any address. Not
   restored: what segcal_work_when_due says, which stays as it is, the scores of watched effects, the segment scored
   last, links and ties of the last calibration. SEGCAL_ERROR_STATE: the device was fed. Until then the device must not
   be used. After an error the store must be opened again before anything is saved, so that what it refused is not
   overwritten by mistake. */
int segcal_restore(segcal_store_t* store, segcal_t* device);

#ifdef __cplusplus
}
#endif
#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
#endif
