#include "semihosting.h"

#include <stdint.h>

enum { SYS_WRITEC = 0x03, SYS_WRITE0 = 0x04, SYS_CLOCK = 0x10, SYS_EXIT_EXTENDED = 0x20, APPLICATION_EXIT = 0x20026 };

static int call(int operation, const void* argument) {
  register int r0 __asm("r0") = operation;
  register const void* r1 __asm("r1") = argument;
  __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

void semihosting_write(const char* text) { call(SYS_WRITE0, text); }
void semihosting_write_char(char c) { call(SYS_WRITEC, &c); }
unsigned semihosting_clock(void) { return (unsigned)call(SYS_CLOCK, 0); }

void semihosting_exit(int code) {
  const uint32_t block[2] = {APPLICATION_EXIT, (uint32_t)code};
  for (;;) call(SYS_EXIT_EXTENDED, block);
}
