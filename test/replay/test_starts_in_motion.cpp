// Devices that are moving when the recording begins, and scatter five times as far as usual. A start whose scale is
// hardly known ends in a filter that believes a wrong speed and gives up seconds later; it waits for frames that tell
// the scale.
#include <unity.h>

#include "../support/cases.h"
#include "replay/counters.h"
#include "simulated_replay.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

void starts_once(std::uint64_t seed) {
  const Id id = Id().add("seed", static_cast<int>(seed));
  if (!test::selected(id.text())) return;
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = 14;
  options.seed = seed;
  options.device_scale = 5;
  options.distortion = host::DistortionModel::radtan;
  const host::ReplayResult replay = test::replayed(host::simulate(options));
  TEST_ASSERT_EQUAL_INT_MESSAGE(0, static_cast<int>(host::count_of(replay.counters, "filter_restarts")),
                                id.text().c_str());
  // Of 140 images at 10 Hz the start takes 8 to 20.
  test::check_between(id, "images used", 120, host::count_of(replay.counters, "frames_used"), 133);
}

/// Each gave up once or twice where the first fit with a speed known to 0.1 m/s was taken.
void test_a_start_waits_until_the_scale_is_known() {
  for (const std::uint64_t seed : {2, 5, 6}) starts_once(seed);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_start_waits_until_the_scale_is_known);
  return UNITY_END();
}
