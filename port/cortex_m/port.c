/* The emulated boards: storage in RAM, log and end through semihosting. */
#include "segcal/port.h"

#include <string.h>

#include "semihosting.h"

enum { kStorageBytes = 16384, kBlockBytes = 1024 };
static unsigned char storage[kStorageBytes];

static int outside(uint32_t offset, uint32_t bytes) { return offset > kStorageBytes || bytes > kStorageBytes - offset; }

uint32_t segcal_port_storage_bytes(void) { return kStorageBytes; }
uint32_t segcal_port_storage_block_bytes(void) { return kBlockBytes; }

int segcal_port_storage_read(uint32_t offset, void* data, uint32_t bytes) {
  if (outside(offset, bytes)) return SEGCAL_PORT_ERROR_RANGE;
  memcpy(data, storage + offset, bytes);
  return SEGCAL_PORT_OK;
}

int segcal_port_storage_write(uint32_t offset, const void* data, uint32_t bytes) {
  if (outside(offset, bytes)) return SEGCAL_PORT_ERROR_RANGE;
  memcpy(storage + offset, data, bytes);
  return SEGCAL_PORT_OK;
}

int segcal_port_storage_erase(uint32_t offset, uint32_t bytes) {
  if (outside(offset, bytes) || offset % kBlockBytes != 0 || bytes % kBlockBytes != 0) return SEGCAL_PORT_ERROR_RANGE;
  memset(storage + offset, 0xFF, bytes);
  return SEGCAL_PORT_OK;
}

int segcal_port_storage_sync(void) { return SEGCAL_PORT_OK; }

void segcal_port_log(const char* line) {
  semihosting_write(line);
  semihosting_write_char('\n');
}

uint64_t segcal_port_clock_us(void) { return (uint64_t)semihosting_clock() * 10000u; }

void segcal_port_assert_failed(const char* condition, const char* file, int line) {
  (void)line;
  semihosting_write(file);
  semihosting_write(": assertion failed: ");
  segcal_port_log(condition);
  semihosting_exit(98);
}
