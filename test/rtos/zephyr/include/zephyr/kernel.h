/* Stand-in: what segcal's port, sample and test use of Zephyr's kernel. */
#ifndef ZEPHYR_KERNEL_H
#define ZEPHYR_KERNEL_H
#include <stddef.h>
#include <stdint.h>

#define __aligned(x) __attribute__((__aligned__(x)))
#define ARG_UNUSED(x) (void)(x)
#define CODE_UNREACHABLE __builtin_unreachable()

int64_t k_uptime_ticks(void);
uint64_t k_ticks_to_us_floor64(uint64_t ticks);
void k_busy_wait(uint32_t usec_to_wait);
void k_panic(void);
#endif
