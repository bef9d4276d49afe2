// A segment that hardly moves tells little, and must not look like a device that has changed.
#include "../support/cases.h"
#include "simulated_replay.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// The first segment after the release tells 0.8 nats. Attitude and the accelerometer's bias are hardly told apart
/// there: its states, 3 deg off as odometry left them, go 15 deg farther before they come back, and after two steps
/// they contradicted what was known (143 on 26 degrees).
void test_a_segment_that_has_not_settled_raises_no_alarm() {
  host::SimulationOptions options;
  options.scenario = "arvr";
  options.seconds = 60;
  options.seed = 13021;
  options.device_seed = 1302;
  const host::SimulationResult session = host::simulate(options);
  host::ReplayOptions replay;
  replay.core.calibration = session.nominal;
  replay.core.noise = session.recording.imu.noise;
  replay.core.condense = replay.core.multi_session = true;
  replay.corner_noise = host::CornerNoise::shown;
  const host::ReplayResult out = host::replay({session.recording}, replay);
  TEST_ASSERT_EQUAL_STRING_MESSAGE("calibrated", out.result.status.c_str(), out.cause.c_str());
  TEST_ASSERT_EQUAL_size_t(0, out.result.changes.size());
  const auto errors = test::normalised_errors(session, out.result);
  for (const host::CoreParameter& p : out.result.parameters)
    if (p.verdict != "fixed")
      test::check_between(test::Id().add("parameter", p.name), "error / sigma", -5, errors.at(p.name), 5);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_segment_that_has_not_settled_raises_no_alarm);
  return UNITY_END();
}
