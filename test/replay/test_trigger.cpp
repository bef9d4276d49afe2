// Calibration begins when the kept segments promise the sigmas that are wanted: soon for loose targets, later for tight
// ones, and the promise is kept.
#include <unity.h>

#include <algorithm>
#include <vector>

#include "../support/cases.h"
#include "api/trigger.h"
#include "simulated_replay.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

/// A triangle of three parameters with sigmas 0.1, 0.5 and `third` of the prior's.
bool reached(float third, float target, bool everything) {
  float data[segcal_mobile::packed_size(3)];
  segcal_mobile::PackedTriangle<float> T(data, 3);
  T.clear();
  T.row(0)[0] = 10;
  T.row(1)[1] = 2;
  T.row(2)[2] = 1 / third;
  const float prior[3] = {2, 3, 4}, targets[3] = {0.21f, 0, target};
  return segcal_mobile::reaches_targets(T, prior, targets, everything);
}

void test_each_target_counts() {
  TEST_ASSERT_TRUE(reached(0.4f, 1.61f, false));
  TEST_ASSERT_FALSE(reached(0.4f, 1.59f, false));
  TEST_ASSERT_TRUE(reached(0.4f, 0, false));      // no target
  TEST_ASSERT_FALSE(reached(0.4f, 1.59f, true));  // shown, but not well enough
  TEST_ASSERT_FALSE(reached(0.9f, 1.59f, false));
  TEST_ASSERT_TRUE(reached(0.9f, 1.59f, true));  // no place left, and hardly shown
}

host::ReplayResult replayed(const host::SimulationResult& session, double fraction) {
  host::ReplayOptions options;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  options.core.metric = "set_d";
  options.core.trigger_fraction = fraction;
  return host::replay({session.recording}, options);
}

void test_the_promise_is_kept() {
  for (int seed = 1; seed <= 2; ++seed) {
    const host::SimulationResult session = test::simulated("rich", 60, static_cast<std::uint64_t>(seed));
    double before = 0;
    for (double fraction : {0.2, 0.05}) {
      const Id id = Id().add("seed", seed).add("fraction", fraction);
      const host::ReplayResult out = replayed(session, fraction);
      const auto first =
          std::find_if(out.calibrations.begin(), out.calibrations.end(), [](const auto& c) { return c.by_targets; });
      test::check_true(id, "the targets were not reached", first != out.calibrations.end());
      TEST_ASSERT_EQUAL_STRING("calibrated", first->status.c_str());
      const double seconds = 1e-9 * static_cast<double>(first->t_ns - session.recording.cameras[0].frames.front().t_ns);
      std::printf("seed %d: %.2f of the prior's sigmas after %.1f s with %d segments\n", seed, fraction, seconds,
                  first->segments);
      test::check_true(id, "a tighter target came first", seconds >= before);
      before = seconds;
      // Segments were scored at the calibration known before, and sigmas grow with chi2/dof where that is above 1.
      for (const host::CoreParameter& p : first->parameters) {
        if (p.name.find(".r_") != std::string::npos) continue;  // printed ones are of the rotation vector's components
        test::check_between(id.add("parameter", p.name), "sigma over the prior's", 0, p.sigma / p.prior_sigma,
                            1.1 * fraction);
      }
    }
  }
}

void test_never_without_targets() {
  const host::SimulationResult session = test::simulated("rich", 40, 3);
  const host::ReplayResult out = replayed(session, 0);
  TEST_ASSERT_EQUAL_INT(1, out.calibrations.size());
  TEST_ASSERT_FALSE(out.calibrations[0].by_targets);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_each_target_counts);
  RUN_TEST(test_the_promise_is_kept);
  RUN_TEST(test_never_without_targets);
  return UNITY_END();
}
