/* The public header in plain C99 with -pedantic: it must compile, link, and need nothing before it. */
#include <segcal/clock.h>
#include <segcal/segcal.h>
#include <segcal/store.h>
#include <unity.h>

void setUp(void) {}
void tearDown(void) {}

static void test_versions_agree(void) { TEST_ASSERT_EQUAL_HEX32(SEGCAL_VERSION, segcal_version()); }

static void test_memory_figures(void) {
  size_t state = 0, segment = 0, workspace = 0;
  segcal_memory(&state, &segment, &workspace);
  TEST_ASSERT_TRUE(state == segcal_storage_bytes());
  TEST_ASSERT_TRUE(state <= SEGCAL_STORAGE_BYTES);
  TEST_ASSERT_TRUE(segment * (SEGCAL_MAX_SEGMENTS + 1) + workspace <= state);
  segcal_memory(NULL, NULL, NULL);
}

/* Zeroes mean defaults, except for the camera itself. */
static void test_zeroes_are_defaults(void) {
  static union {
    long double align;
    unsigned char bytes[SEGCAL_STORAGE_BYTES];
  } storage;
  static segcal_config_t config;
  segcal_t* device = NULL;
  config.camera[0].model = SEGCAL_RADTAN;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CONFIG, segcal_create(&device, &config, storage.bytes, sizeof storage.bytes));
  config.camera[0].intrinsics[0] = config.camera[0].intrinsics[1] = 400;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_create(&device, &config, storage.bytes, sizeof storage.bytes));
  TEST_ASSERT_NOT_NULL(device);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_versions_agree);
  RUN_TEST(test_memory_figures);
  RUN_TEST(test_zeroes_are_defaults);
  return UNITY_END();
}
