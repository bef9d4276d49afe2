/* Zephyr: log through printk, storage in the flash partition `segcal_storage` where there is one. */
#include "segcal/port.h"

#include <zephyr/kernel.h>
#include <zephyr/sys/printk.h>

#if defined(CONFIG_FLASH_MAP)
#include <zephyr/storage/flash_map.h>
#define HAS_STORAGE FIXED_PARTITION_EXISTS(segcal_storage)
#else
#define HAS_STORAGE 0
#endif

enum { kBlockBytes = 4096 };

#if HAS_STORAGE

/* Null if the partition cannot be opened. */
static const struct flash_area* storage(void) {
  static const struct flash_area* area;
  if (!area && flash_area_open(FIXED_PARTITION_ID(segcal_storage), &area) != 0) area = NULL;
  return area;
}

static int range_error(uint32_t offset, uint32_t bytes) {
  const uint32_t end = segcal_port_storage_bytes();
  return offset > end || bytes > end - offset;
}

uint32_t segcal_port_storage_bytes(void) { return storage() ? FIXED_PARTITION_SIZE(segcal_storage) : 0; }

int segcal_port_storage_read(uint32_t offset, void* data, uint32_t bytes) {
  if (range_error(offset, bytes)) return SEGCAL_PORT_ERROR_RANGE;
  return flash_area_read(storage(), offset, data, bytes) == 0 ? SEGCAL_PORT_OK : SEGCAL_PORT_ERROR_DEVICE;
}

int segcal_port_storage_write(uint32_t offset, const void* data, uint32_t bytes) {
  if (range_error(offset, bytes)) return SEGCAL_PORT_ERROR_RANGE;
  return flash_area_write(storage(), offset, data, bytes) == 0 ? SEGCAL_PORT_OK : SEGCAL_PORT_ERROR_DEVICE;
}

int segcal_port_storage_erase(uint32_t offset, uint32_t bytes) {
  if (range_error(offset, bytes) || offset % kBlockBytes != 0 || bytes % kBlockBytes != 0)
    return SEGCAL_PORT_ERROR_RANGE;
  return flash_area_erase(storage(), offset, bytes) == 0 ? SEGCAL_PORT_OK : SEGCAL_PORT_ERROR_DEVICE;
}

#else

uint32_t segcal_port_storage_bytes(void) { return 0; }

int segcal_port_storage_read(uint32_t offset, void* data, uint32_t bytes) {
  ARG_UNUSED(offset), ARG_UNUSED(data), ARG_UNUSED(bytes);
  return SEGCAL_PORT_ERROR_RANGE;
}

int segcal_port_storage_write(uint32_t offset, const void* data, uint32_t bytes) {
  ARG_UNUSED(offset), ARG_UNUSED(data), ARG_UNUSED(bytes);
  return SEGCAL_PORT_ERROR_RANGE;
}

int segcal_port_storage_erase(uint32_t offset, uint32_t bytes) {
  ARG_UNUSED(offset), ARG_UNUSED(bytes);
  return SEGCAL_PORT_ERROR_RANGE;
}

#endif

uint32_t segcal_port_storage_block_bytes(void) { return kBlockBytes; }
int segcal_port_storage_sync(void) { return SEGCAL_PORT_OK; }

void segcal_port_log(const char* line) { printk("%s\n", line); }

uint64_t segcal_port_clock_us(void) { return k_ticks_to_us_floor64((uint64_t)k_uptime_ticks()); }

void segcal_port_assert_failed(const char* condition, const char* file, int line) {
  printk("%s:%d: assertion failed: %s\n", file, line, condition);
  k_panic();
  CODE_UNREACHABLE;
}
