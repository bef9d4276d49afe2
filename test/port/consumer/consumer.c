/* A C program that knows of segcal only what is installed. Exit code 0: headers and library agree. */
#include "segcal/segcal.h"

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));

int main(void) {
  static segcal_config_t config;
  segcal_t *device;
  config.camera[0].intrinsics[0] = config.camera[0].intrinsics[1] = 256;
  if (segcal_version() != SEGCAL_VERSION || segcal_storage_bytes() > sizeof memory) return 1;
  return segcal_create(&device, &config, memory, sizeof memory) == SEGCAL_OK ? 0 : 2;
}
