/* The library on a board: what its memory and arithmetic must be like, a calibration from end to end, the port. */
#include <zephyr/kernel.h>
#include <zephyr/ztest.h>

#include "segcal/port.h"
#include "stream.h"

static char memory[SEGCAL_STORAGE_BYTES] __aligned(SEGCAL_STORAGE_ALIGNMENT);
static segcal_config_t config;
static segcal_t* device;

ZTEST_SUITE(segcal, NULL, NULL, NULL, NULL, NULL);

ZTEST(segcal, test_memory) {
  stream_config(&config);
  zassert_true(segcal_storage_bytes() <= sizeof memory);
  zassert_equal(segcal_create(&device, &config, memory, sizeof memory), SEGCAL_OK);
  zassert_equal(segcal_create(&device, &config, memory, segcal_storage_bytes() - 1), SEGCAL_ERROR_SIZE);
  zassert_equal(segcal_create(&device, &config, memory + 1, sizeof memory - 1), SEGCAL_ERROR_ALIGNMENT);
}

/* Rounds to nearest and keeps subnormal numbers: without, the bits are others. */
ZTEST(segcal, test_arithmetic) {
  volatile float smallest_normal = 1.17549435e-38f, one = 1, step = 5.9604645e-08f, three = 3;
  zassert_true(smallest_normal / 2 > 0);
  zassert_true(one + step == one);
  zassert_true(one + three * step > one);
  zassert_true(one / three * three == one);
}

ZTEST(segcal, test_calibration) {
  stream_config(&config);
  zassert_equal(segcal_create(&device, &config, memory, sizeof memory), SEGCAL_OK);
  const uint64_t hash = stream_hash(device);
  TC_PRINT("profile %d, hash %016llx\n", SEGCAL_PROFILE, (unsigned long long)hash);
  zassert_not_equal(hash, 0);
}

ZTEST(segcal, test_clock_and_log) {
  const uint64_t before = segcal_port_clock_us();
  segcal_port_log("a line of the port");
  k_busy_wait(2000);
  const uint64_t passed = segcal_port_clock_us() - before;
  zassert_true(passed >= 1000 && passed < 1000000);
}

ZTEST(segcal, test_storage) {
  const uint32_t end = segcal_port_storage_bytes(), block = segcal_port_storage_block_bytes();
  unsigned char back[3] = {0};
#if defined(CONFIG_FLASH_MAP)
  zassert_true(end >= 2 * block);
#else
  zassert_equal(end, 0);
#endif
  zassert_equal(segcal_port_storage_read(end, back, 1), SEGCAL_PORT_ERROR_RANGE);
  zassert_equal(segcal_port_storage_write(end, "x", 1), SEGCAL_PORT_ERROR_RANGE);
  zassert_equal(segcal_port_storage_erase(end, block), SEGCAL_PORT_ERROR_RANGE);
  if (end == 0) return;
  zassert_equal(segcal_port_storage_erase(1, block), SEGCAL_PORT_ERROR_RANGE);
  zassert_equal(segcal_port_storage_erase(0, 2 * block), SEGCAL_PORT_OK);
  zassert_equal(segcal_port_storage_write(block - 1, "ab", 2), SEGCAL_PORT_OK);
  zassert_equal(segcal_port_storage_sync(), SEGCAL_PORT_OK);
  zassert_equal(segcal_port_storage_read(block - 1, back, 3), SEGCAL_PORT_OK);
  zassert_true(back[0] == 'a' && back[1] == 'b' && back[2] == 0xFF);
  zassert_equal(segcal_port_storage_erase(block, block), SEGCAL_PORT_OK);
  zassert_equal(segcal_port_storage_read(block - 1, back, 2), SEGCAL_PORT_OK);
  zassert_true(back[0] == 'a' && back[1] == 0xFF);
}
