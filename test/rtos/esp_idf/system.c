/* Stand-in for ESP-IDF on a PC: log to stdout, a clock, a data partition `segcal` in RAM whose bits can only be cleared
 * until they are erased. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "esp_log.h"
#include "esp_partition.h"
#include "esp_timer.h"

enum { kBytes = 0x4000, kEraseBytes = 4096 };
static unsigned char flash[kBytes];
static const esp_partition_t segcal = {
    ESP_PARTITION_TYPE_DATA, ESP_PARTITION_SUBTYPE_ANY, 0x110000, kBytes, kEraseBytes, "segcal"};

void stub_log(char level, const char* tag, const char* format, ...) {
  va_list arguments;
  printf("%c (%s) ", level, tag);
  va_start(arguments, format);
  vprintf(format, arguments);
  va_end(arguments);
  printf("\n");
}

int64_t esp_timer_get_time(void) { return (int64_t)clock() * 1000000 / CLOCKS_PER_SEC; }

const esp_partition_t* esp_partition_find_first(esp_partition_type_t type, esp_partition_subtype_t subtype,
                                                const char* label) {
  return type == segcal.type && subtype == segcal.subtype && strcmp(label, segcal.label) == 0 ? &segcal : NULL;
}
static esp_err_t outside(const esp_partition_t* partition, size_t offset, size_t size) {
  if (partition != &segcal || offset > kBytes) return ESP_ERR_INVALID_ARG;
  return size > kBytes - offset ? ESP_ERR_INVALID_SIZE : ESP_OK;
}
esp_err_t esp_partition_read(const esp_partition_t* partition, size_t src_offset, void* dst, size_t size) {
  const esp_err_t error = outside(partition, src_offset, size);
  if (error == ESP_OK) memcpy(dst, flash + src_offset, size);
  return error;
}
esp_err_t esp_partition_write(const esp_partition_t* partition, size_t dst_offset, const void* src, size_t size) {
  const esp_err_t error = outside(partition, dst_offset, size);
  for (size_t i = 0; error == ESP_OK && i < size; ++i) flash[dst_offset + i] &= ((const unsigned char*)src)[i];
  return error;
}
esp_err_t esp_partition_erase_range(const esp_partition_t* partition, size_t offset, size_t size) {
  if (offset % kEraseBytes != 0 || size % kEraseBytes != 0) return ESP_ERR_INVALID_ARG;
  const esp_err_t error = outside(partition, offset, size);
  if (error == ESP_OK) memset(flash + offset, 0xFF, size);
  return error;
}
