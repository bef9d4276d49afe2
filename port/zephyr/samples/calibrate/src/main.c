/* Prints one number that stands for every bit of a calibration: the same on each board, and the same that
 * examples/hash.c prints on a PC for profile 1. Another number means that an option is missing, or that the FPU does
 * not follow IEEE 754 (docs/porting.md, section 3). */
#include <zephyr/kernel.h>
#include <zephyr/sys/printk.h>

#include "stream.h"

static char memory[SEGCAL_STORAGE_BYTES] __aligned(SEGCAL_STORAGE_ALIGNMENT);
static segcal_config_t config;

int main(void) {
  segcal_t* device;
  stream_config(&config);
  if (segcal_create(&device, &config, memory, sizeof memory) != SEGCAL_OK) {
    printk("segcal_create refuses\n");
    return 0;
  }
  printk("profile %d, hash %016llx\n", SEGCAL_PROFILE, (unsigned long long)stream_hash(device));
  return 0;
}
