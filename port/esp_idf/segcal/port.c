/* ESP-IDF: log through ESP_LOG, storage in the data partition labelled `segcal` where the partition table has one. */
#include "segcal/port.h"

#include <stdlib.h>

#include "esp_log.h"
#include "esp_partition.h"
#include "esp_timer.h"

enum { kBlockBytes = 4096 };

/* Null if there is no such partition. */
static const esp_partition_t* storage(void) {
  static const esp_partition_t* partition;
  if (!partition) partition = esp_partition_find_first(ESP_PARTITION_TYPE_DATA, ESP_PARTITION_SUBTYPE_ANY, "segcal");
  return partition;
}

static int range_error(uint32_t offset, uint32_t bytes) {
  const uint32_t end = segcal_port_storage_bytes();
  return end == 0 || offset > end || bytes > end - offset;
}

static int answer(esp_err_t error) { return error == ESP_OK ? SEGCAL_PORT_OK : SEGCAL_PORT_ERROR_DEVICE; }

uint32_t segcal_port_storage_bytes(void) { return storage() ? (uint32_t)storage()->size : 0; }
uint32_t segcal_port_storage_block_bytes(void) { return kBlockBytes; }

int segcal_port_storage_read(uint32_t offset, void* data, uint32_t bytes) {
  if (range_error(offset, bytes)) return SEGCAL_PORT_ERROR_RANGE;
  return answer(esp_partition_read(storage(), offset, data, bytes));
}

int segcal_port_storage_write(uint32_t offset, const void* data, uint32_t bytes) {
  if (range_error(offset, bytes)) return SEGCAL_PORT_ERROR_RANGE;
  return answer(esp_partition_write(storage(), offset, data, bytes));
}

int segcal_port_storage_erase(uint32_t offset, uint32_t bytes) {
  if (range_error(offset, bytes) || offset % kBlockBytes != 0 || bytes % kBlockBytes != 0)
    return SEGCAL_PORT_ERROR_RANGE;
  return answer(esp_partition_erase_range(storage(), offset, bytes));
}

int segcal_port_storage_sync(void) { return SEGCAL_PORT_OK; }

void segcal_port_log(const char* line) { ESP_LOGI("segcal", "%s", line); }

uint64_t segcal_port_clock_us(void) { return (uint64_t)esp_timer_get_time(); }

void segcal_port_assert_failed(const char* condition, const char* file, int line) {
  ESP_LOGE("segcal", "%s:%d: assertion failed: %s", file, line, condition);
  abort();
}
