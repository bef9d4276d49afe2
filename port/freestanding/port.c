/* A port that gives nothing: the core runs with it as it is. Copy this folder, then fill in what your platform has. */
#include "segcal/port.h"

uint32_t segcal_port_storage_bytes(void) { return 0; }
uint32_t segcal_port_storage_block_bytes(void) { return 1; }

int segcal_port_storage_read(uint32_t offset, void* data, uint32_t bytes) {
  (void)offset, (void)data, (void)bytes;
  return SEGCAL_PORT_ERROR_RANGE;
}

int segcal_port_storage_write(uint32_t offset, const void* data, uint32_t bytes) {
  (void)offset, (void)data, (void)bytes;
  return SEGCAL_PORT_ERROR_RANGE;
}

int segcal_port_storage_erase(uint32_t offset, uint32_t bytes) {
  (void)offset, (void)bytes;
  return SEGCAL_PORT_ERROR_RANGE;
}

int segcal_port_storage_sync(void) { return SEGCAL_PORT_OK; }

void segcal_port_log(const char* line) { (void)line; }

uint64_t segcal_port_clock_us(void) { return 0; }

void segcal_port_assert_failed(const char* condition, const char* file, int line) {
  (void)condition, (void)file, (void)line;
  for (;;) {
  }
}
