/* Stand-in for Zephyr's kernel on a PC: a clock of 10 kHz, printk to stdout, flash in RAM, a runner of tests. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zephyr/kernel.h>
#include <zephyr/storage/flash_map.h>
#include <zephyr/ztest.h>

void printk(const char* fmt, ...) {
  va_list arguments;
  va_start(arguments, fmt);
  vprintf(fmt, arguments);
  va_end(arguments);
}

int64_t k_uptime_ticks(void) { return (int64_t)clock() * 10000 / CLOCKS_PER_SEC; }
uint64_t k_ticks_to_us_floor64(uint64_t ticks) { return ticks * 100; }
void k_busy_wait(uint32_t usec_to_wait) {
  for (const clock_t start = clock(); (clock() - start) * 1000000. / CLOCKS_PER_SEC <= usec_to_wait;) {
  }
}
void k_panic(void) { exit(1); }

/* Bits can only be cleared until they are erased, as in a NOR flash. */
static unsigned char flash[FIXED_PARTITION_SIZE(segcal_storage)];
static const struct flash_area area = {FIXED_PARTITION_ID(segcal_storage), 0x100000, sizeof flash};

static int outside(const struct flash_area* fa, off_t off, size_t len) {
  return fa != &area || off < 0 || (size_t)off > sizeof flash || len > sizeof flash - (size_t)off;
}
int flash_area_open(uint8_t id, const struct flash_area** fa) {
  *fa = &area;
  return id == area.fa_id ? 0 : -2;
}
int flash_area_read(const struct flash_area* fa, off_t off, void* dst, size_t len) {
  if (outside(fa, off, len)) return -22;
  memcpy(dst, flash + off, len);
  return 0;
}
int flash_area_write(const struct flash_area* fa, off_t off, const void* src, size_t len) {
  if (outside(fa, off, len)) return -22;
  for (size_t i = 0; i < len; ++i) flash[(size_t)off + i] &= ((const unsigned char*)src)[i];
  return 0;
}
int flash_area_erase(const struct flash_area* fa, off_t off, size_t len) {
  if (outside(fa, off, len) || off % 4096 != 0 || len % 4096 != 0) return -22;
  memset(flash + off, 0xFF, len);
  return 0;
}

#if defined(CONFIG_ZTEST)
static struct {
  const char *suite, *name;
  void (*function)(void);
} tests[16];
static int n_tests;

void stub_add_test(const char* suite, const char* name, void (*function)(void)) {
  tests[n_tests].suite = suite;
  tests[n_tests].name = name;
  tests[n_tests++].function = function;
}
void stub_assert(bool holds, const char* condition, const char* file, int line) {
  if (holds) return;
  printk("%s:%d: %s\n", file, line, condition);
  exit(1);
}
int main(void) {
  for (int i = 0; i < n_tests; ++i) {
    tests[i].function();
    printk("PASS %s.%s\n", tests[i].suite, tests[i].name);
  }
  printk("%d tests passed\n", n_tests);
  return n_tests == 0;
}
#endif
