/* Calls each function of a port once; exit code 0 if the answers are possible ones. PORT_HAS_STORAGE: the port must
 * have some. */
#include <stdint.h>

#include "segcal/port.h"

int main(int argc, char** argv) {
  unsigned char byte = 7, back = 0;
  const uint32_t end = segcal_port_storage_bytes(), block = segcal_port_storage_block_bytes();
  (void)argv;
  if (argc > 1) segcal_port_assert_failed("argc == 1", __FILE__, __LINE__);
  segcal_port_log("a line");
  if (segcal_port_clock_us() > segcal_port_clock_us()) return 1;
  if (segcal_port_storage_read(end, &back, 1) != SEGCAL_PORT_ERROR_RANGE) return 2;
  if (segcal_port_storage_write(end, &byte, 1) != SEGCAL_PORT_ERROR_RANGE) return 3;
#if defined(PORT_HAS_STORAGE)
  if (end == 0) return 8;
#endif
  if (end == 0) return segcal_port_storage_erase(0, block) == SEGCAL_PORT_ERROR_RANGE ? 0 : 4;
  if (segcal_port_storage_erase(0, block) != SEGCAL_PORT_OK || segcal_port_storage_write(3, &byte, 1) != SEGCAL_PORT_OK)
    return 5;
  if (segcal_port_storage_sync() != SEGCAL_PORT_OK || segcal_port_storage_read(3, &back, 1) != SEGCAL_PORT_OK) return 6;
  return back == byte ? 0 : 7;
}
