/* The C API on the target: bad arguments are refused, bad data is survived, and old contents of the memory do not
 * matter. */
#include <string.h>
#include <unity.h>

#include "segcal/segcal.h"
#include "tests.h"

static char memory[SEGCAL_STORAGE_BYTES] __attribute__((aligned(SEGCAL_STORAGE_ALIGNMENT)));
static segcal_config_t config;
static segcal_t* device;

static void make_device(int dirt) {
  memset(&config, 0, sizeof config);
  memset(memory, dirt, sizeof memory);
  config.camera[0].intrinsics[0] = config.camera[0].intrinsics[1] = 256;
  config.camera[0].intrinsics[2] = 320;
  config.camera[0].intrinsics[3] = 240;
  config.camera[0].distortion[0] = 0.92;
  TEST_ASSERT_EQUAL(SEGCAL_OK, segcal_create(&device, &config, memory, sizeof memory));
}

static void create_refuses_bad_memory(void) {
  make_device(0);
  TEST_ASSERT_EQUAL(SEGCAL_ERROR_NULL, segcal_create(&device, &config, 0, sizeof memory));
  TEST_ASSERT_EQUAL(SEGCAL_ERROR_SIZE, segcal_create(&device, &config, memory, segcal_storage_bytes() - 1));
  TEST_ASSERT_EQUAL(SEGCAL_ERROR_ALIGNMENT, segcal_create(&device, &config, memory + 4, sizeof memory));
  config.camera[0].intrinsics[0] = -1;
  TEST_ASSERT_EQUAL(SEGCAL_ERROR_CONFIG, segcal_create(&device, &config, memory, sizeof memory));
}

static void bad_samples_are_counted(void) {
  const segcal_imu_t good = {1000, {0, 0, 0}, {0, 0, 9.8f}, 0};
  segcal_imu_t bad = good;
  segcal_counters_t counters;
  union {
    uint32_t bits;
    float value;
  } not_a_number = {0x7FC00000u};
  make_device(0);
  TEST_ASSERT_EQUAL(SEGCAL_OK, segcal_push_imu(device, &good));
  TEST_ASSERT_EQUAL(SEGCAL_ERROR_STAMP, segcal_push_imu(device, &good));
  bad.t_ns = 2000;
  bad.gyro[1] = not_a_number.value;
  TEST_ASSERT_EQUAL(SEGCAL_ERROR_NOT_FINITE, segcal_push_imu(device, &bad));
  TEST_ASSERT_EQUAL(SEGCAL_OK, segcal_get_counters(device, &counters));
  TEST_ASSERT_EQUAL_UINT32(3, counters.imu_samples);
  TEST_ASSERT_EQUAL_UINT32(1, counters.imu_stamps_back);
  TEST_ASSERT_EQUAL_UINT32(1, counters.imu_not_finite);
}

/* Two seconds at rest under a fixed grid of 30 points. */
static uint64_t hash_of_a_short_feed(int dirt) {
  static segcal_point_t points[30];
  make_device(dirt);
  for (int i = 0; i < 30; ++i) {
    points[i].track_id = (uint32_t)(i + 1);
    points[i].u = 60.0f + 100.0f * (float)(i % 6);
    points[i].v = 50.0f + 90.0f * (float)(i / 6);
  }
  for (int i = 0; i <= 400; ++i) {
    const float shake = 0.01f * (float)(i % 7 - 3);
    const segcal_imu_t sample = {(int64_t)i * 5000000, {0.1f * shake, -0.2f * shake, 0}, {0.1f, shake, 9.8f}, 0};
    TEST_ASSERT_TRUE(segcal_push_imu(device, &sample) >= 0);
    if (i % 20 != 0) continue;
    TEST_ASSERT_TRUE(segcal_push_tracks(device, sample.t_ns, points, 30) >= 0);
  }
  return segcal_result_hash(device);
}

static void old_contents_of_the_memory_do_not_matter(void) {
  const uint64_t clean = hash_of_a_short_feed(0);
  segcal_state_t state;
  TEST_ASSERT_EQUAL_MESSAGE(SEGCAL_OK, segcal_get_state(device, &state),
                            "the filter did not start, so nothing was compared");
  TEST_ASSERT_TRUE(clean == hash_of_a_short_feed(0xFF));
  TEST_ASSERT_TRUE(clean == hash_of_a_short_feed(0x5A));
}

void test_api(void) {
  RUN_TEST(create_refuses_bad_memory);
  RUN_TEST(bad_samples_are_counted);
  RUN_TEST(old_contents_of_the_memory_do_not_matter);
}
