// When a log takes the device's state, and what it answers until that is whole.
#include <functional>

#include "rotating_device.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

/// Until an announced state is whole, nothing may come before it, and nothing may come before it is announced.
void test_a_state_comes_first() {
  const segcal_config_t c = rotating_config();
  Storage storage(0xA5);
  segcal_t* device = created(&storage, c);
  segcal_flash_t flash;
  segcal_store_t store;
  const std::function<int(Writer*)> calls[] = {
      [](Writer* log) { return segcal_log_imu(&log->log, &session(0).imu[0]); },
      [](Writer* log) { return segcal_log_tracks(&log->log, 0, nullptr, 0); },
      [](Writer* log) { return segcal_log_mark(&log->log, SEGCAL_LOG_NEW_SESSION); },
      [](Writer* log) { return segcal_log_hash(&log->log, 1); }, [](Writer* log) { return segcal_log_end(&log->log); }};
  for (const auto& call : calls) {
    Writer log(c);
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_state(&log.log, device, &flash));
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, call(&log));
    finish(&store, segcal_store_open(&store, &flash));
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_save(&store, device));
    TEST_ASSERT_EQUAL_INT(1, segcal_store_work(&store, 3));
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, call(&log));
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, finish(&store, 1));
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, call(&log));
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_log_state(&log.log, device, &flash));
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STORAGE, save(flash, device));
  }
  Writer log(c);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_log_state(nullptr, device, &flash));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_log_state(&log.log, device, nullptr));
  TEST_ASSERT_LESS_THAN_INT(0, segcal_log_state(&log.log, nullptr, &flash));
  Writer again(c);  // a save that stops between the first sync and the last page, and another one
  device = created(&storage, c);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_state(&again.log, device, &flash));
  finish(&store, segcal_store_open(&store, &flash));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_save(&store, device));
  while (again.log.syncs == 0) TEST_ASSERT_EQUAL_INT(1, segcal_store_work(&store, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_log_hash(&again.log, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(flash, device));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_hash(&again.log, 1));
}

void test_a_session_under_way_has_no_state() {
  const segcal_config_t c = rotating_config();
  Storage storage(0xA5);
  segcal_t* device = created(&storage, c);
  segcal_flash_t flash;
  Writer log(c), late(c);
  log.feed(device, 0, 1000000);
  segcal_flush(device);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_log_state(&late.log, device, &flash));  // no session begins here
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_state_comes_first);
  RUN_TEST(test_a_session_under_way_has_no_state);
  return UNITY_END();
}
