// A recording's twin from end to end: with what a diagnosis found the simulation comes near to the measurement, without
// it does not.
#include <string>

#include "../support/cases.h"
#include "simulate/effect_names.h"
#include "simulate/simulate.h"
#include "twin/twin.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using host::twin::Comparison;
using host::twin::Statistic;

struct Case {
  const char* effect;
  bool drift;
  const char* name;
};

Comparison compared(const Case& c) {
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = 40;
  options.seed = 5;
  if (c.drift) options.tracks = host::sim::drifting_tracks();
  options.effects.push_back(host::sim::parse_effect(c.effect));
  const host::SimulationResult session = host::simulate(options);
  host::DiagnoseOptions diagnose;
  diagnose.core.calibration = session.nominal;
  diagnose.core.noise = session.recording.imu.noise;
  const host::Diagnosis found = host::diagnose({session.recording}, diagnose);
  return host::twin::compare_with_twin(session.recording, found, diagnose);
}

/// The goal: each statistic's difference is at most a third of what it was. What chance does to it is allowed for with
/// two sigmas, and sums of squares of the sensors with a tenth more: they are that of another draw of the noise.
void expect_nearer(const Comparison& twin) {
  int differ = 0;
  for (const Statistic& s : twin.statistics) {
    if (!s.differs()) continue;
    ++differ;
    TEST_ASSERT_TRUE_MESSAGE(s.left() - 2 * s.left_sigma() <= 1.0 / 3 + 0.1,
                             (s.name + ": " + std::to_string(s.left()) + " left").c_str());
  }
  TEST_ASSERT_GREATER_OR_EQUAL_INT_MESSAGE(5, differ, "too few statistics see the effect");
}

void test_simulation_comes_near_to_the_measurement() {
  for (const Case& c : {Case{"time_offset=0.003", false, "time_offset"}, Case{"gyro_lag=0.004", true, "gyro_lag"}}) {
    if (!test::selected(test::Id().add("effect", c.name).text())) continue;
    const Comparison twin = compared(c);
    TEST_ASSERT_EQUAL_STRING("", twin.why_not.c_str());
    TEST_ASSERT_GREATER_THAN(35, static_cast<int>(twin.seconds));  // of 40 s, a start of a few
    expect_nearer(twin);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, static_cast<int>(twin.said_of_plain.find("consistent")),
                                  twin.said_of_plain.c_str());
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, static_cast<int>(twin.said_of_twin.find("explained")), twin.said_of_twin.c_str());
    TEST_ASSERT_TRUE_MESSAGE(twin.said_of_twin.find(c.name) != std::string::npos, twin.said_of_twin.c_str());
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_simulation_comes_near_to_the_measurement);
  return UNITY_END();
}
