/* The flash that a store works on, and what the store says of itself. docs/storage.md says every byte, and why a power cut at
 * any moment leaves the old state or the new one, whole. The library is segcal_store, beside segcal.
 */
#ifndef SEGCAL_STORE_H
#define SEGCAL_STORE_H

#include "segcal/segcal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Of the stored bytes; not the library's. A store of a newer major format is refused, all of a newer minor one is readable. */
#define SEGCAL_STORE_MAJOR 1u
#define SEGCAL_STORE_MINOR 0u

/* ---- what the platform gives ---- */
/* A function's answer: 0 done; SEGCAL_FLASH_BAD: this block, or what is read, is unusable, others may be well; anything else: the
   medium cannot be reached, and the call that needed it fails. */
enum { SEGCAL_FLASH_BAD = 1 };

typedef struct {
  void *context;
  uint32_t program_bytes; /* smallest unit that is programmed, a power of two, 1..256; offsets and lengths are multiples */
  uint32_t erase_bytes;   /* of a block; a multiple of SEGCAL_STORE_PAGE_MAX, 512..16 MiB */
  uint32_t blocks;        /* 2..65535 */
  /* Bytes of a block as they are. Erased ones read 0xFF. */
  int (*read)(void *context, uint32_t block, uint32_t offset, void *to, uint32_t n);
  /* Erased bytes, each once between two erasures. May be reordered, torn and lost by a power cut until sync returned. */
  int (*program)(void *context, uint32_t block, uint32_t offset, const void *from, uint32_t n);
  int (*erase)(void *context, uint32_t block);
  /* Returns when all that was programmed and erased is on the medium. */
  int (*sync)(void *context);
} segcal_flash_t;

#define SEGCAL_STORE_PAGE_MAX 256

/* ---- what a store says of itself ---- */
typedef struct {
  int32_t ready;          /* 1: opened, nothing under way */
  uint32_t generation;    /* of the newest whole state: grows with each save; 0: nothing is stored */
  uint32_t blocks;        /* that it takes, unusable ones between them included */
  uint32_t passed_over;   /* newer states that were not whole, when it was last looked for: interrupted saves, or damage */
  uint32_t bad_blocks;    /* skipped since the store was opened: the port refused them, or they did not read back as programmed */
  uint32_t erases, programs;  /* since the store was opened */
  uint32_t library_version, format_major, format_minor; /* that wrote the newest whole state; after SEGCAL_ERROR_VERSION: what is
                                                           stored and cannot be read */
} segcal_store_info_t;

#ifdef __cplusplus
}
#endif
#endif
