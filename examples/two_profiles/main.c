/* Two profiles of segcal in one program: a small one for one device, a large one for another. */
#include <stdio.h>

int small_device(void), large_device(void);

int main(void) {
  const int small = small_device(), large = large_device();
  printf("keyframes of a segment: mcu %d, mobile %d\n", small, large);
  return small > 0 && large > 0 ? 0 : 1;
}
