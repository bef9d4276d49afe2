/* All that segcal and the compiler need of a C library. Yours are faster: then leave this file out. */
#include <stddef.h>

/* Without the option GCC makes of each loop a call of the function that it is in. */
#define PLAIN __attribute__((used, optimize("no-tree-loop-distribute-patterns")))

PLAIN void* memcpy(void* to, const void* from, size_t n) {
  for (size_t i = 0; i < n; ++i) ((char*)to)[i] = ((const char*)from)[i];
  return to;
}

PLAIN void* memmove(void* to, const void* from, size_t n) {
  if ((char*)to <= (const char*)from) return memcpy(to, from, n);
  while (n-- > 0) ((char*)to)[n] = ((const char*)from)[n];
  return to;
}

PLAIN void* memset(void* to, int value, size_t n) {
  for (size_t i = 0; i < n; ++i) ((char*)to)[i] = (char)value;
  return to;
}
