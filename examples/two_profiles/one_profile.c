/* Compiled once for each profile, linked with that profile's library (segcal_add_core in lib/CMakeLists.txt):
 * SEGCAL_RENAME gives the C functions another prefix, SEGCAL_PROFILE the capacities. */
#include "stream.h"

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config;

/* Makes a device and calibrates it; returns the number that stands for every bit of the result, 0 if there is none. */
uint64_t NAME(void) {
  segcal_t* device;
  stream_config(&config);
  return segcal_create(&device, &config, memory, sizeof memory) == SEGCAL_OK ? stream_hash(device) : 0;
}
