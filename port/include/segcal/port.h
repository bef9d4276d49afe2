/* What a platform gives to segcal: storage, a log sink, a clock, and what to do when an assertion fails. A port defines
 * these functions; the linker binds them, so there is no table of pointers and the call graph stays provable. C99.
 *
 * The core in lib/ needs none of it: it never blocks, stores nothing, reads no clock, and calls only
 * segcal_port_assert_failed, and that only in a build with SEGCAL_ASSERT=1. Device logs, event lines and the programs
 * in examples and tests use the rest. port/freestanding/port.c is the empty one, to copy; docs/porting.md is the guide.
 */
#ifndef SEGCAL_PORT_H
#define SEGCAL_PORT_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- storage: one area of bytes that outlives a restart, such as some pages of flash ---- */
enum {
  SEGCAL_PORT_OK = 0,
  SEGCAL_PORT_ERROR_RANGE = -1, /* beyond the area; nothing was done */
  SEGCAL_PORT_ERROR_DEVICE = -2 /* the medium failed */
};
/* Bytes of the area; 0: none. Erased bytes read 0xFF. */
uint32_t segcal_port_storage_bytes(void);
/* Bytes that are erased together; offsets and lengths given to erase are multiples of it. */
uint32_t segcal_port_storage_block_bytes(void);
int segcal_port_storage_read(uint32_t offset, void* data, uint32_t bytes);
/* Writes erased bytes, in any number of calls, each byte once between two erasures. Returns when the bytes are
   accepted; they are on the medium after segcal_port_storage_sync. A power cut may lose or tear what was not
   synchronised, nothing else. */
int segcal_port_storage_write(uint32_t offset, const void* data, uint32_t bytes);
int segcal_port_storage_erase(uint32_t offset, uint32_t bytes);
int segcal_port_storage_sync(void);

/* ---- log sink: one line without its end of line; may drop it, must not block ---- */
void segcal_port_log(const char* line);

/* ---- clock, microseconds from any origin, for statistics only: no result depends on it ---- */
uint64_t segcal_port_clock_us(void);

/* ---- a broken assertion: says so and does not return ---- */
#ifdef __cplusplus
[[noreturn]]
#elif defined(__GNUC__)
__attribute__((noreturn))
#endif
void segcal_port_assert_failed(const char *condition, const char *file, int line);

/* With SEGCAL_ASSERT=1 the core checks its own assumptions, Eigen's included: for development, about twice the
   instructions. Not given or 0: no code at all. The same for the core and its libraries store and clock: objects are
   larger with it, and calls of a store that was compiled without it answer SEGCAL_ERROR_STATE. */
#if defined(SEGCAL_ASSERT) && SEGCAL_ASSERT
#define SEGCAL_PORT_ASSERT(condition) \
  ((condition) ? (void)0 : segcal_port_assert_failed(#condition, __FILE__, __LINE__))
#else
#define SEGCAL_PORT_ASSERT(condition) ((void)0)
#endif

#ifdef __cplusplus
}
#endif
#endif
