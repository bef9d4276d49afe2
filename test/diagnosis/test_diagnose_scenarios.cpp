// Diagnosis on motions other than `rich`: a headset (arvr) and a ground robot (nav), whose images move slowly. Each
// kind on one of them; where SEGCAL_LONG is set, on both.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "../support/cases.h"
#include "diagnose/diagnose.h"
#include "simulate/effect_names.h"
#include "simulate/simulate.h"
#include "simulate/spoil.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using host::Diagnosis;

Diagnosis diagnosed(const std::string& scenario, std::uint64_t seed, const std::string& effect,
                    const host::sim::TrackOptions& tracks = {}, std::vector<std::string>* steps = nullptr) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = 60;
  options.seed = seed;
  options.tracks = tracks;
  if (!effect.empty()) options.effects.push_back(host::sim::parse_effect(effect));
  const host::SimulationResult session = host::simulate(options);
  host::DiagnoseOptions diagnose;
  diagnose.core.calibration = session.nominal;
  diagnose.core.noise = session.recording.imu.noise;
  if (steps) {
    diagnose.progress = [steps](const std::string& step, double) {
      if (steps->empty() || steps->back() != step) steps->push_back(step);
    };
  }
  const Diagnosis d = host::diagnose({session.recording}, diagnose);
  std::printf("segcal simulate --scenario %s --seconds 60 --seed %d%s: %s\n", scenario.c_str(), static_cast<int>(seed),
              effect.empty() ? "" : (" --effect " + effect).c_str(), d.sentence.c_str());
  return d;
}

bool long_run() { return std::getenv("SEGCAL_LONG") != nullptr; }

std::vector<const char*> scenarios(const char* always, const char* in_long_runs) {
  return long_run() ? std::vector<const char*>{always, in_long_runs} : std::vector<const char*>{always};
}

/// The name, no other, and the value: within 4 sigma (one of
/// 16,000) and a share of it that the linear model leaves out.
void expect_only(const Diagnosis& d, const std::string& name, double truth, double share) {
  TEST_ASSERT_EQUAL_STRING_MESSAGE("explained", d.verdict.c_str(), d.sentence.c_str());
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, static_cast<int>(d.effects.size()), d.sentence.c_str());
  TEST_ASSERT_EQUAL_STRING_MESSAGE(name.c_str(), d.effects[0].name.c_str(), d.sentence.c_str());
  const host::DiagnosedParameter& p = d.effects[0].parameters.at(0);
  TEST_ASSERT_DOUBLE_WITHIN(4 * p.sigma + share * std::abs(truth), truth, p.value);
}

void test_nothing_missing() {
  for (const char* scenario : scenarios("arvr", "nav")) {
    const Diagnosis d = diagnosed(scenario, 1, "");
    TEST_ASSERT_EQUAL_STRING_MESSAGE("consistent", d.verdict.c_str(), d.sentence.c_str());
    TEST_ASSERT_TRUE(d.judged && d.effects.empty());
  }
}

/// The largest that is an effect and not a fault, and one that is small for a slow robot. 1 %: the pose is taken along
/// its velocity, which changes in 90 ms.
void test_time_offsets() {
  expect_only(diagnosed("arvr", 105, "time_offset=0.09"), "time_offset", 0.09, 0.01);
  expect_only(diagnosed("nav", 106, "time_offset=0.003"), "time_offset", 0.003, 0);
}

/// 1 %: over half a frame's 4.8 ms the velocity changes.
void test_rolling_shutter() {
  for (const char* scenario : scenarios("nav", "arvr")) {
    expect_only(diagnosed(scenario, 120, "rolling_shutter=2e-5"), "rolling_shutter", 2e-5, 0.01);
  }
}

/// 24 ms of read-out, shaken by hand: the filter loses itself until rotation tells the delay.
void test_rolling_shutter_of_a_shaken_phone() {
  expect_only(diagnosed("rich", 42, "rolling_shutter=5e-5", host::sim::drifting_tracks()), "rolling_shutter", 5e-5,
              0.01);
}

/// Without the drift in the weights both are `unexplained`. The
/// second also where image motion is read from points that drift.
void test_tracks_that_drift() {
  if (long_run()) {
    const Diagnosis nothing = diagnosed("rich", 131, "", host::sim::drifting_tracks());
    TEST_ASSERT_EQUAL_STRING_MESSAGE("consistent", nothing.verdict.c_str(), nothing.sentence.c_str());
  }
  std::vector<std::string> steps;
  const Diagnosis d = diagnosed("arvr", 120103, "rolling_shutter=1.6e-5", host::sim::drifting_tracks(), &steps);
  expect_only(d, "rolling_shutter", 1.6e-5, 0.01);
  TEST_ASSERT_DOUBLE_WITHIN(0.03, 0.1,
                            d.tracks.white_px);  // a twentieth of it at 15,000 points, and what the fit leaves
  TEST_ASSERT_DOUBLE_WITHIN(0.09, 0.9, d.tracks.walk_px_per_sqrt_s);
  // Asked before the points are weighed by the drift the dictionary took the work that the catalogue needed after it.
  TEST_ASSERT_EQUAL_INT(1, std::count(steps.begin(), steps.end(), "terms beyond the catalogue"));
}

/// Residuals walk along each track as well, at 2.7 px/sqrt(s), but those of neighbours together.
void test_what_is_missing_is_no_drift() {
  const Diagnosis d = diagnosed("rich", 501, "outside:attitude_error=0.8");
  TEST_ASSERT_EQUAL_STRING_MESSAGE("unexplained", d.verdict.c_str(), d.sentence.c_str());
  TEST_ASSERT_EQUAL_INT(0, d.tracks.points);
}

/// A step in the middle closes half of the gap of what drifts, and is not held against its scatter: the name is the
/// effect's all the same. The accelerometer's bias moves by 1 m/s^2, far from where the fit without it is linearised.
/// The filter starts after 8 s, and what is left of 60 s shows a step of three directions well, with a statistic of
/// 154, and one of six of the temperature, with 75: by what a plausible size of each makes likely, it is the
/// temperature.
void test_what_follows_temperature() {
  expect_only(diagnosed("nav", 90010070,
                        "camera_temperature=0.000719036,0.00122826,0.00062959,-9.63656e-05,0.00055774,-0.0001497"),
              "camera_temperature", 0.000719036, 0);
  if (!long_run()) return;
  const Diagnosis d = diagnosed("nav", 80010067, "accel_temperature=-0.0157255,0.0415302,0.0816575");
  expect_only(d, "accel_temperature", -0.0157255, 0);
}

/// The image moves by 4 px in the middle: a step is taken, an effect is tried beside it and refused. What follows is of
/// the fit without that effect.
void test_an_effect_that_is_tried_leaves_nothing() {
  host::SimulationOptions options;
  options.scenario = "arvr";
  options.seconds = 60;
  options.seed = 32;
  host::SimulationResult session = host::simulate(options);
  host::sim::spoil::move_pixels(session.recording, 4, 0);
  host::DiagnoseOptions diagnose;
  diagnose.core.calibration = session.nominal;
  diagnose.core.noise = session.recording.imu.noise;
  diagnose.accept_faults = true;
  const Diagnosis d = host::diagnose({session.recording}, diagnose);
  TEST_ASSERT_EQUAL_STRING_MESSAGE("unexplained", d.verdict.c_str(), d.sentence.c_str());
  TEST_ASSERT_TRUE(d.effects.empty());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_nothing_missing);
  RUN_TEST(test_time_offsets);
  RUN_TEST(test_rolling_shutter);
  RUN_TEST(test_rolling_shutter_of_a_shaken_phone);
  RUN_TEST(test_tracks_that_drift);
  RUN_TEST(test_what_is_missing_is_no_drift);
  RUN_TEST(test_what_follows_temperature);
  RUN_TEST(test_an_effect_that_is_tried_leaves_nothing);
  return UNITY_END();
}
