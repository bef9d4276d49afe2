/* Prints one number that stands for every bit of a calibration. Wherever it was built, and in whatever way, it is the
 * same for the same profile; another number means that an option is missing (docs/porting.md, section 1). */
#include <inttypes.h>
#include <stdio.h>

#include "stream.h"

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config;

int main(void) {
  segcal_t* device;
  stream_config(&config);
  if (segcal_create(&device, &config, memory, sizeof memory) != SEGCAL_OK) return 2;
  const uint64_t hash = stream_hash(device);
  printf("profile %d, hash %016" PRIx64 "\n", SEGCAL_PROFILE, hash);
  return hash ? 0 : 1;
}
