/* Prints one number that stands for every bit of a calibration. */
#include <inttypes.h>
#include <stdio.h>

#include "stream.h"

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config;

void app_main(void) {
  segcal_t* device;
  stream_config(&config);
  if (segcal_create(&device, &config, memory, sizeof memory) != SEGCAL_OK) {
    printf("segcal_create refuses\n");
    return;
  }
  printf("profile %d, hash %016" PRIx64 "\n", SEGCAL_PROFILE, stream_hash(device));
}
