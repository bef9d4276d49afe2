/* Stand-in: a board whose device tree has the partition segcal_storage and no other. */
#ifndef ZEPHYR_STORAGE_FLASH_MAP_H
#define ZEPHYR_STORAGE_FLASH_MAP_H
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#define STUB_PARTITION_segcal_storage 1
#define FIXED_PARTITION_EXISTS(label) STUB_PARTITION_##label
#define FIXED_PARTITION_ID(label) STUB_PARTITION_##label
#define FIXED_PARTITION_SIZE(label) 0x4000

struct flash_area {
  uint8_t fa_id;
  off_t fa_off;
  size_t fa_size;
};
int flash_area_open(uint8_t id, const struct flash_area** fa);
int flash_area_read(const struct flash_area* fa, off_t off, void* dst, size_t len);
int flash_area_write(const struct flash_area* fa, off_t off, const void* src, size_t len);
int flash_area_erase(const struct flash_area* fa, off_t off, size_t len);
#endif
