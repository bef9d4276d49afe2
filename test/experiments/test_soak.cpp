// The study of long runs: what a short one counts, and that the gathering sees what grows or goes wrong.
#include <unity.h>

#include "experiments/registry.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace host::experiments;

/// Two sessions of a minute; in the second one bursts of IMU samples are lost, and a tenth of some seconds' images.
const CellResult& short_run() {
  static const CellResult cell = [] {
    const Json parameters = {{"profile", "mobile"}, {"hours", 2.0 / 60}, {"session_s", 60}, {"seed", 14}};
    return CellResult{parameters, soak_run(parameters)};
  }();
  return cell;
}

void test_a_short_run_is_counted_and_right() {
  const Json& first = short_run().result.at("parts").at(0);
  const Json& second = short_run().result.at("parts").at(6);  // of twelve
  TEST_ASSERT_EQUAL_INT(601, first.at("frames").get<int>());
  TEST_ASSERT_EQUAL_INT(1, first.at("clean").at("sessions").get<int>());
  TEST_ASSERT_EQUAL_INT(1, first.at("clean").at("calibrated").get<int>());
  TEST_ASSERT_EQUAL_INT(0, first.at("clean").at("wrong").get<int>());
  TEST_ASSERT_EQUAL_INT(1, second.at("with_faults").at("sessions").get<int>());
  // A minute of shaking determines all 26; their mean square is below 2.3 in 999 of 1000 honest runs.
  TEST_ASSERT_EQUAL_INT(26, first.at("clean").at("entries").get<int>());
  TEST_ASSERT_TRUE(first.at("clean").at("sum_of_squares").get<double>() < 2.3 * 26);
  // The filter's tilt is known to some mrad (test/vio); a frame
  // of reference that is mixed up would be tenths of a radian.
  TEST_ASSERT_TRUE(first.at("tilt_mrad").get<double>() < 20);
  TEST_ASSERT_TRUE(second.at("frames").get<int>() < 601);
  TEST_ASSERT_TRUE(short_run().result.at("counters").contains("imu_gaps"));
}

bool all_met(const Json& result) {
  for (const Limit& limit : soak_gather({{short_run().parameters, result}}).limits)
    if (!limit.met()) return false;
  return true;
}

/// Of a run within its limits, one figure at a time is made worse.
void test_each_limit_can_be_missed() {
  Json good = short_run().result;
  good["parts"][0]["clean"]["sum_of_squares"] = 26;
  good["parts"][6]["frame_ms"] = good["parts"][0]["frame_ms"];
  good["peak_kb"] = good["peak_kb_first"];
  TEST_ASSERT_TRUE(all_met(good));
  const auto missed = [&](auto change) {
    Json bad = good;
    change(&bad);
    return !all_met(bad);
  };
  TEST_ASSERT_TRUE(missed([](Json* j) { (*j)["parts"][0]["clean"]["sum_of_squares"] = 1.3 * 26; }));
  TEST_ASSERT_TRUE(missed([](Json* j) { (*j)["parts"][0]["clean"]["sum_of_squares"] = 0.7 * 26; }));
  TEST_ASSERT_TRUE(missed([](Json* j) { (*j)["parts"][0]["clean"]["wrong"] = 1; }));
  TEST_ASSERT_TRUE(
      missed([](Json* j) { (*j)["parts"][6]["frame_ms"] = 1.2 * (*j)["parts"][0]["frame_ms"].get<double>(); }));
  TEST_ASSERT_TRUE(missed([](Json* j) { (*j)["peak_kb"] = (*j)["peak_kb"].get<double>() + 40000; }));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_short_run_is_counted_and_right);
  RUN_TEST(test_each_limit_can_be_missed);
  return UNITY_END();
}
