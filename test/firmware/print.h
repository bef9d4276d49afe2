/* Numbers through the port's log, without printf: an image has none. Doubles as their 16 hexadecimal digits. */
#ifndef SEGCAL_TEST_PRINT_H
#define SEGCAL_TEST_PRINT_H

#include <stdint.h>
#include <string.h>

#include "segcal/port.h"

static inline void print_line(const char* line) { segcal_port_log(line); }

static inline char* put_name(char* out, const char* name) {
  while (*name) *out++ = *name++;
  *out++ = ' ';
  return out;
}

static inline void print_number(const char* name, uint32_t value) {
  char line[64], digits[10], *out = put_name(line, name);
  int n = 0;
  do digits[n++] = (char)('0' + value % 10);
  while ((value /= 10) != 0);
  while (n > 0) *out++ = digits[--n];
  *out = 0;
  print_line(line);
}

static inline void print_hex(const char* name, uint64_t value) {
  char line[64], *out = put_name(line, name);
  for (int i = 60; i >= 0; i -= 4) *out++ = "0123456789abcdef"[(value >> i) & 15u];
  *out = 0;
  print_line(line);
}

static inline void print_double(const char* name, double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  print_hex(name, bits);
}

#endif
