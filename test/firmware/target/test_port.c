/* What every port promises (port/include/segcal/port.h). */
#include <string.h>
#include <unity.h>

#include "segcal/port.h"
#include "tests.h"

enum { kBytes = 24 };

static void storage_reads_back_what_was_written(void) {
  char out[kBytes], in[kBytes] = "twenty-four bytes of it";
  const uint32_t block = segcal_port_storage_block_bytes();
  if (segcal_port_storage_bytes() == 0) TEST_IGNORE_MESSAGE("this port has no storage");
  TEST_ASSERT_EQUAL(SEGCAL_PORT_OK, segcal_port_storage_erase(0, 2 * block));
  TEST_ASSERT_EQUAL(SEGCAL_PORT_OK, segcal_port_storage_write(block - 8, in, kBytes)); /* over the edge of a block */
  TEST_ASSERT_EQUAL(SEGCAL_PORT_OK, segcal_port_storage_sync());
  TEST_ASSERT_EQUAL(SEGCAL_PORT_OK, segcal_port_storage_read(block - 8, out, kBytes));
  TEST_ASSERT_EQUAL_MEMORY(in, out, kBytes);
}

static void erased_storage_reads_ff(void) {
  unsigned char byte = 0;
  const uint32_t block = segcal_port_storage_block_bytes();
  if (segcal_port_storage_bytes() == 0) TEST_IGNORE_MESSAGE("this port has no storage");
  TEST_ASSERT_EQUAL(SEGCAL_PORT_OK, segcal_port_storage_write(block, &byte, 1));
  TEST_ASSERT_EQUAL(SEGCAL_PORT_OK, segcal_port_storage_erase(block, block));
  TEST_ASSERT_EQUAL(SEGCAL_PORT_OK, segcal_port_storage_read(block, &byte, 1));
  TEST_ASSERT_EQUAL_HEX8(0xFF, byte);
}

static void storage_refuses_what_lies_outside(void) {
  char byte = 0;
  const uint32_t end = segcal_port_storage_bytes();
  TEST_ASSERT_EQUAL(SEGCAL_PORT_ERROR_RANGE, segcal_port_storage_read(end, &byte, 1));
  TEST_ASSERT_EQUAL(SEGCAL_PORT_ERROR_RANGE, segcal_port_storage_write(end, &byte, 1));
  TEST_ASSERT_EQUAL(SEGCAL_PORT_ERROR_RANGE,
                    segcal_port_storage_read(0xFFFFFFFFu, &byte, 2)); /* the sum wraps around */
  TEST_ASSERT_EQUAL(SEGCAL_PORT_ERROR_RANGE, segcal_port_storage_erase(end, segcal_port_storage_block_bytes()));
}

static void clock_does_not_go_back(void) {
  const uint64_t first = segcal_port_clock_us();
  for (int i = 0; i < 100; ++i) TEST_ASSERT_TRUE(segcal_port_clock_us() >= first);
}

void test_port(void) {
  RUN_TEST(storage_reads_back_what_was_written);
  RUN_TEST(erased_storage_reads_ff);
  RUN_TEST(storage_refuses_what_lies_outside);
  RUN_TEST(clock_does_not_go_back);
}
