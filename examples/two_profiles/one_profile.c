/* Compiled once for each profile, linked with that profile's library (segcal_add_core in lib/CMakeLists.txt): SEGCAL_RENAME gives the C
 * functions another prefix, SEGCAL_PROFILE the capacities. */
#include "segcal/segcal.h"

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));

/* Makes a device; its keyframes per segment, or a negative error. */
int NAME(void) {
  static segcal_config_t config;
  segcal_t *device;
  config.camera[0].intrinsics[0] = config.camera[0].intrinsics[1] = 256;
  const int code = segcal_create(&device, &config, memory, sizeof memory);
  return code == SEGCAL_OK ? SEGCAL_MAX_KEYFRAMES : code;
}
