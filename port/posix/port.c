/* Linux, macOS and other hosts: storage in a file that SEGCAL_STORAGE names, log on stderr, the monotonic clock. */
#define _POSIX_C_SOURCE 200809L
#include "segcal/port.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { kStorageBytes = 1 << 20, kBlockBytes = 4096 };

/* Opened at the first use and kept open; null if no file is named or it cannot be made. */
static FILE* storage(void) {
  static FILE* file;
  const char* path = getenv("SEGCAL_STORAGE");
  if (file || !path) return file;
  file = fopen(path, "r+b");
  if (file) return file;
  file = fopen(path, "w+b");
  if (file && segcal_port_storage_erase(0, kStorageBytes) != SEGCAL_PORT_OK) {
    fclose(file);
    file = NULL;
  }
  return file;
}

static int seek(FILE* file, uint32_t offset, uint32_t bytes) {
  if (!file || offset > kStorageBytes || bytes > kStorageBytes - offset) return SEGCAL_PORT_ERROR_RANGE;
  return fseek(file, (long)offset, SEEK_SET) == 0 ? SEGCAL_PORT_OK : SEGCAL_PORT_ERROR_DEVICE;
}

uint32_t segcal_port_storage_bytes(void) { return storage() ? kStorageBytes : 0; }
uint32_t segcal_port_storage_block_bytes(void) { return kBlockBytes; }

int segcal_port_storage_read(uint32_t offset, void* data, uint32_t bytes) {
  FILE* file = storage();
  const int error = seek(file, offset, bytes);
  if (error != SEGCAL_PORT_OK) return error;
  return fread(data, 1, bytes, file) == bytes ? SEGCAL_PORT_OK : SEGCAL_PORT_ERROR_DEVICE;
}

int segcal_port_storage_write(uint32_t offset, const void* data, uint32_t bytes) {
  FILE* file = storage();
  const int error = seek(file, offset, bytes);
  if (error != SEGCAL_PORT_OK) return error;
  return fwrite(data, 1, bytes, file) == bytes ? SEGCAL_PORT_OK : SEGCAL_PORT_ERROR_DEVICE;
}

int segcal_port_storage_erase(uint32_t offset, uint32_t bytes) {
  unsigned char erased[kBlockBytes];
  if (offset % kBlockBytes != 0 || bytes % kBlockBytes != 0) return SEGCAL_PORT_ERROR_RANGE;
  memset(erased, 0xFF, sizeof erased);
  for (uint32_t done = 0; done < bytes; done += kBlockBytes) {
    const int error = segcal_port_storage_write(offset + done, erased, kBlockBytes);
    if (error != SEGCAL_PORT_OK) return error;
  }
  return SEGCAL_PORT_OK;
}

int segcal_port_storage_sync(void) {
  FILE* file = storage();
  return !file || fflush(file) == 0 ? SEGCAL_PORT_OK : SEGCAL_PORT_ERROR_DEVICE;
}

void segcal_port_log(const char* line) { fprintf(stderr, "%s\n", line); }

uint64_t segcal_port_clock_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
}

void segcal_port_assert_failed(const char* condition, const char* file, int line) {
  fprintf(stderr, "%s:%d: assertion failed: %s\n", file, line, condition);
  abort();
}
