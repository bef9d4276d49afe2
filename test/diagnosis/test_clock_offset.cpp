// Clocks too far apart for any fit: when is an offset named by rotation alone?
#include <unity.h>

#include <algorithm>

#include "../support/cases.h"
#include "diagnose/answer.h"
#include "diagnose/clock_offset.h"
#include "diagnose/decision.h"
#include "simulate/effect_names.h"
#include "simulate/simulate.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using host::Diagnosis;
using host::diagnosis::Budget;
using test::Id;

/// A minute's walk whose camera is late by 80 ms on average, and by `apart_s` less in every other ten seconds than in
/// the rest. Nothing is fitted: the odometry is lost with the stamps as they are, and all is well with those that
/// rotation gives.
Diagnosis diagnosed(double apart_s, double open = 0) {
  host::SimulationOptions options;
  options.scenario = "nav";
  options.seconds = 60;
  options.seed = 7;
  const host::SimulationResult session = host::simulate(options);
  std::vector<host::Recording> sessions{session.recording};
  for (host::Frame& f : sessions[0].cameras[0].frames) {
    const std::int64_t ten_s = (f.t_ns - sessions[0].imu.samples.front().t_ns) / 10'000'000'000;
    f.t_ns -= static_cast<std::int64_t>(1e9 * (0.08 + (ten_s % 2 == 0 ? 0.5 : -0.5) * apart_s));
  }
  host::CoreOptions core;
  core.calibration = session.nominal;
  int runs = 0;
  return host::diagnosis::with_clocks_aligned(
      sessions, core,
      [&runs, open](const std::vector<host::Recording>&, const host::diagnosis::Told& told, Budget& budget) {
        Diagnosis out;
        out.before.total = 1;
        out.open_excess = open;
        if (runs++ == 0) out.lost = "odometry is lost";
        TEST_ASSERT_TRUE(budget.must_answer());
        TEST_ASSERT_EQUAL_UINT(runs == 1 ? 0 : 1, told.effects.size());
        TEST_ASSERT_EQUAL_INT(runs > 1, told.has("time_offset"));
        return out;
      });
}

/// Stamps of its images are 80 ms early.
host::SimulationResult late_walk() {
  host::SimulationOptions options;
  options.scenario = "nav";
  options.seconds = 60;
  options.seed = 9;
  host::SimulationResult session = host::simulate(options);
  for (host::Frame& f : session.recording.cameras[0].frames) f.t_ns -= 80'000'000;
  return session;
}

/// The first look used its work up and found no name: what rotation tells may have been in the way, and gets a second
/// look with less work, which counts if it finds a name.
void test_a_second_look_has_less_work() {
  const host::SimulationResult session = late_walk();
  host::CoreOptions core;
  core.calibration = session.nominal;
  using host::diagnosis::decision::kSlices, host::diagnosis::decision::kSlicesAgain;
  for (const auto& [second, used] : {std::pair("explained", kSlices), std::pair("unexplained", kSlices / 4)}) {
    int runs = 0;
    const Diagnosis d = host::diagnosis::with_clocks_aligned(
        {session.recording}, core,
        [&runs, second, used](const std::vector<host::Recording>&, const host::diagnosis::Told& told, Budget& budget) {
          Diagnosis out;
          const bool first = runs++ == 0;
          out.verdict = first ? "unexplained" : second;
          out.judged = true;
          out.seconds = runs;
          TEST_ASSERT_EQUAL_INT(first, budget.must_answer());
          TEST_ASSERT_TRUE(budget.left() == (first ? kSlices : std::max<std::int64_t>(kSlicesAgain, kSlices - used)));
          if (first) budget.take(used);
          TEST_ASSERT_EQUAL_INT(!first, told.has("time_offset"));
          return out;
        });
    TEST_ASSERT_EQUAL_INT(2, runs);
    TEST_ASSERT_EQUAL_INT(std::string(second) == "explained" ? 2 : 1, static_cast<int>(d.seconds));
  }
}

/// Where nothing could be judged without it, the second look counts if it can.
void test_a_second_look_where_little_was_fitted() {
  const host::SimulationResult session = late_walk();
  host::CoreOptions core;
  core.calibration = session.nominal;
  for (const bool judged : {true, false}) {
    int runs = 0;
    const Diagnosis d = host::diagnosis::with_clocks_aligned(
        {session.recording}, core, [&runs, judged = judged](const std::vector<host::Recording>&, const auto&, Budget&) {
          Diagnosis out;
          out.judged = runs++ > 0 && judged;
          out.seconds = runs;
          return out;
        });
    TEST_ASSERT_EQUAL_INT(2, runs);
    TEST_ASSERT_EQUAL_INT(judged ? 2 : 1, static_cast<int>(d.seconds));
  }
}

/// To the 4 ms that rotation is wrong by in a walk, by parallax.
void test_one_offset_is_named() {
  const Diagnosis d = diagnosed(0);
  TEST_ASSERT_EQUAL_UINT(1, d.effects.size());
  TEST_ASSERT_EQUAL_STRING("time_offset", d.effects[0].name.c_str());
  test::check_near(Id(), "offset, s", 0.08, d.effects[0].parameters.at(0).value, 0.004);
  test::check_between(Id(), "sigma, s", 0.004, d.effects[0].parameters.at(0).sigma, 0.0057);
}

/// A gyroscope that lags behind some turns and not behind others was named as a clock.
void test_several_offsets_are_none() {
  TEST_ASSERT_EQUAL_UINT(1, diagnosed(0.06).effects.size());  // nothing else is open: the fit agrees
  const Diagnosis d = diagnosed(0.06, 1);
  TEST_ASSERT_EQUAL_UINT(0, d.effects.size());
  TEST_ASSERT_EQUAL_STRING("unexplained", d.verdict.c_str());
  TEST_ASSERT_EQUAL_UINT(1, std::count_if(d.rejected.begin(), d.rejected.end(), [](const auto& r) {
                           return r.name == "time_offset" && r.why.find("rotation alone shows") == 0;
                         }));
}

/// Both are told of a phone that is shaken, whose clocks are apart as well. 4 us: parallax, and an offset that is known
/// to 4 ms.
void test_a_rolling_shutter_is_told() {
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = 30;
  options.seed = 8;
  options.effects = {host::sim::parse_effect("rolling_shutter=6e-5"), host::sim::parse_effect("time_offset=0.05")};
  const host::SimulationResult session = host::simulate(options);
  host::CoreOptions core;
  core.calibration = session.nominal;
  int runs = 0;
  host::diagnosis::with_clocks_aligned(
      {session.recording}, core,
      [&runs](const std::vector<host::Recording>&, const host::diagnosis::Told& told, Budget&) {
        Diagnosis out;
        if (runs++ == 0) {
          out.lost = "odometry is lost";
          return out;
        }
        TEST_ASSERT_TRUE(told.has("time_offset") && told.has("rolling_shutter"));
        test::check_near(Id(), "line delay, s", 6e-5, told.line_delay, 4e-6);
        return out;
      });
  TEST_ASSERT_EQUAL_INT(2, runs);
}

/// A device whose odometry is lost. `turned`: its gyroscope's axes stand otherwise than stated.
Diagnosis not_started(const char* scenario, bool turned, double late_s = 0, std::uint32_t restarts = 0) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = 30;
  options.seed = 9;
  host::SimulationResult session = host::simulate(options);
  for (host::ImuSample& s : session.recording.imu.samples)
    if (turned) s.gyro = {s.gyro[1], -s.gyro[0], s.gyro[2]};
  for (host::Frame& f : session.recording.cameras[0].frames) f.t_ns -= static_cast<std::int64_t>(1e9 * late_s);
  host::CoreOptions core;
  core.calibration = session.nominal;
  return host::diagnosis::with_clocks_aligned(
      {session.recording}, core,
      [restarts](const std::vector<host::Recording>&, const host::diagnosis::Told&, Budget&) {
        Diagnosis out;
        out.fit_before.counters = {{"filter_restarts", restarts}};
        out.lost = "odometry diverges";
        host::diagnosis::conclude(&out);
        return out;
      });
}

/// "Odometry diverges, look for the lens" sent whoever only turned the device in his hands after faults that it has
/// not.
void test_turning_in_place_is_no_wrong_model() {
  for (double late_s : {0.0, 0.08}) {
    const Diagnosis still = not_started("rotation", false, late_s);
    TEST_ASSERT_FALSE(still.judged);
    TEST_ASSERT_EQUAL_STRING("consistent", still.verdict.c_str());
    TEST_ASSERT_TRUE_MESSAGE(still.sentence.find("the device turns in place") != std::string::npos,
                             still.sentence.c_str());
  }
  // Axes that are wrong; a filter that ran; a device that moves.
  for (const Diagnosis& wrong :
       {not_started("rotation", true), not_started("rotation", false, 0, 2), not_started("rich", false)}) {
    TEST_ASSERT_TRUE(wrong.judged);
    TEST_ASSERT_EQUAL_STRING("odometry diverges", wrong.sentence.c_str());
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_a_second_look_has_less_work);
  RUN_TEST(test_a_second_look_where_little_was_fitted);
  RUN_TEST(test_one_offset_is_named);
  RUN_TEST(test_several_offsets_are_none);
  RUN_TEST(test_a_rolling_shutter_is_told);
  RUN_TEST(test_turning_in_place_is_no_wrong_model);
  return UNITY_END();
}
