/* Two profiles of segcal in one program: a small one for one device, a large one for another. Each gives what it gives
 * alone (hash.c). */
#include <inttypes.h>
#include <stdio.h>

uint64_t small_device(void), large_device(void);

int main(void) {
  const uint64_t small = small_device(), large = large_device();
  printf("profile 1, hash %016" PRIx64 "\nprofile 2, hash %016" PRIx64 "\n", small, large);
  return small && large ? 0 : 1;
}
