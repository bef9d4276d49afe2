/* Two builds of one profile with different capacities in one program, or OWN_ONLY: the one that differs by itself. */
#include <inttypes.h>
#include <stdio.h>

uint64_t own_device(void), mcu_device(void);

int main(void) {
  const uint64_t own = own_device();
  printf("profile 1, hash %016" PRIx64 "\n", own);
#ifdef OWN_ONLY
  return own ? 0 : 1;
#else
  const uint64_t mcu = mcu_device();
  printf("profile 1, hash %016" PRIx64 "\n", mcu);
  return own && mcu && own != mcu ? 0 : 1;
#endif
}
