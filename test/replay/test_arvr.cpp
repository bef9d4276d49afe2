// A headset's two minutes: the eight segments that the device keeps must tell nearly as much as all that happened.
#include <unity.h>

#include <algorithm>
#include <vector>

#include "../support/cases.h"
#include "simulated_replay.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

/// sigma with eight segments over sigma with every segment, by name. Both in profile host, the only one that holds all:
/// another profile cuts other keyframes and landmarks out of the same seconds, and the choice alone is to be judged.
std::map<std::string, double> sigma_ratios(int seed) {
  const host::SimulationResult session = test::simulated("arvr", 120, static_cast<std::uint64_t>(seed));
  const host::ReplayResult eight = test::replayed(session, "host", 8), all = test::replayed(session, "host", 64);
  TEST_ASSERT_EQUAL_STRING("calibrated", eight.result.status.c_str());
  TEST_ASSERT_EQUAL_STRING("calibrated", all.result.status.c_str());
  TEST_ASSERT_EQUAL_INT(8, eight.result.segments);
  std::map<std::string, double> out;
  const auto few = test::sigmas(eight.result), many = test::sigmas(all.result);
  for (const auto& [name, sigma] : few) out[name] = sigma / many.at(name);
  std::printf("seed %d: %zu segments, 8 against %d;", seed, eight.segments.size(), all.result.segments);
  return out;
}

void print(const std::map<std::string, double>& ratios) {
  for (const auto& [kind, ratio] : test::largest_by_kind(ratios)) std::printf(" %s %.2f", kind.c_str(), ratio);
  std::printf("\n");
}

void test_eight_segments_tell_nearly_all() {
  const int seeds = test::long_run() ? 5 : 1;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Id id = Id().add("seed", seed);
    if (!test::selected(id.text())) continue;
    const auto ratios = sigma_ratios(seed);
    print(ratios);
    for (const auto& [name, ratio] : ratios)
      test::check_between(id.add("parameter", name), "ratio of sigmas", 0, ratio, 1.5);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_eight_segments_tell_nearly_all);
  return UNITY_END();
}
