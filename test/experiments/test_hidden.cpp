// The study of hidden effects: its cases are complete, and its judge counts right answers only.
#include <cmath>
#include <map>
#include <set>

#include "../support/cases.h"
#include "experiments/hidden_answer.h"
#include "experiments/hidden_cases.h"
#include "experiments/registry.h"
#include "experiments/wrong_lens.h"
#include "simulate/effect_names.h"
#include "simulate/simulate.h"
#include "unity.h"

using host::experiments::Json;

namespace {

void cases_are_complete_and_reproducible() {
  const auto cells = host::experiments::hidden_cells({});
  std::map<std::string, int> groups, effects;
  std::set<std::string> names;
  for (const auto& cell : cells) {
    TEST_ASSERT_TRUE_MESSAGE(names.insert(cell.name).second, cell.name.c_str());
    ++groups[cell.parameters.at("group")];
    for (const Json& text : cell.parameters.at("effects")) {
      const auto effect = host::sim::parse_effect(text);  // throws what is wrong with it
      const std::string scenario = cell.parameters.at("scenario");
      if (cell.parameters.at("group") == "one" || cell.parameters.at("group") == "fault")
        ++effects[scenario + " " + effect->truth().name];
    }
  }
  TEST_ASSERT_EQUAL_INT(150, groups["none"]);
  TEST_ASSERT_EQUAL_INT(60, groups["two"]);
  TEST_ASSERT_EQUAL_INT(120, groups["outside"]);
  TEST_ASSERT_EQUAL_INT(40, groups["weak"]);
  for (const auto& entry : host::sim::effect_entries()) {
    if (entry.kind != host::sim::EffectKind::catalogue) continue;
    const bool fault =
        effects.count(std::string("rich ") + entry.name) && !effects.count(std::string("nav ") + entry.name);
    for (const char* scenario : {"rich ", "arvr ", "nav "}) {
      if (!fault || scenario[0] == 'r')
        TEST_ASSERT_EQUAL_INT_MESSAGE(10, effects[std::string(scenario) + entry.name], entry.name);
    }
  }
  const auto again = host::experiments::hidden_cells({});
  for (std::size_t k = 0; k < cells.size(); ++k) TEST_ASSERT_TRUE(cells[k].parameters == again[k].parameters);
}

/// A range that is given as a share of the largest reading: some samples stand at it, and none beyond.
void saturation_clips_in_every_session() {
  int seen = 0;
  for (const auto& cell : host::experiments::hidden_cells({})) {
    const std::string effect =
        cell.parameters.at("effects").empty() ? "" : std::string(cell.parameters.at("effects")[0]);
    if (effect.rfind("saturation=", 0) != 0 || ++seen > 2) continue;
    const host::SimulationResult session = host::experiments::hidden_session(cell.parameters);
    const bool gyro = effect.substr(effect.size() - 2) == ",0";
    std::map<double, int> count;
    for (const auto& s : session.recording.imu.samples)
      for (double value : gyro ? s.gyro : s.accel) ++count[std::abs(value)];
    const int at_limit = count.rbegin()->second;
    TEST_ASSERT_GREATER_OR_EQUAL_INT_MESSAGE(3, at_limit, effect.c_str());
  }
  TEST_ASSERT_EQUAL_INT(10, seen);
}

/// An answer as `diagnosed` gives it.
Json answer(const std::string& verdict, const std::vector<std::string>& named, const Json& values = Json::object()) {
  return {{"verdict", verdict}, {"judged", true},          {"named", named},
          {"values", values},   {"pairs", Json::array()},  {"gap_closed", 0.97},
          {"cannot_tell", 0},   {"faults", Json::array()}, {"statistics", {{"time_offset", 300}, {"gyro_lag", 20}}},
          {"seconds", 12.0}};
}

host::experiments::CellResult cell(const std::string& group, const std::vector<std::string>& there, const Json& values,
                                   const Json& said) {
  return {{{"group", group},
           {"scenario", "rich"},
           {"distortion", "fov"},
           {"tracks", "white"},
           {"images_per_s", 10},
           {"effects", there},
           {"seed", 1}},
          {{"truth", {{"names", there}, {"values", values}}}, {"answer", said}}};
}

void right_and_wrong_answers_are_told_apart() {
  const Json truth = {{"time_offset.t_d", 3e-3}};
  const auto judge = [&truth](const Json& said) {
    return host::experiments::judged(cell("one", {"time_offset"}, truth, said));
  };
  auto j = judge(answer("explained", {"time_offset"}, {{"time_offset.t_d", {3.02e-3, 1e-5}}}));
  TEST_ASSERT_TRUE(j.exact && j.in_three_sigma && !j.false_name);
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2, j.worst_sigmas);
  j = judge(answer("explained", {"time_offset"}, {{"time_offset.t_d", {3.05e-3, 1e-5}}}));
  TEST_ASSERT_TRUE(j.exact && !j.in_three_sigma);
  j = judge(answer("explained", {"gyro_lag"}));
  TEST_ASSERT_TRUE(!j.exact && j.false_name);
  j = judge(answer("explained", {"time_offset", "gyro_lag"}));
  TEST_ASSERT_TRUE(!j.exact && j.false_name);
  j = judge(answer("consistent", {}));
  TEST_ASSERT_TRUE(!j.exact && !j.false_name);
  j = judge(answer("explained", {"unlisted"}));
  TEST_ASSERT_TRUE(!j.exact && !j.false_name && j.unlisted);
  Json bad = answer("bad_data", {});
  bad["faults"] = {"saturation", "saturation"};
  TEST_ASSERT_TRUE(host::experiments::judged(cell("fault", {"saturation"}, Json::object(), bad)).exact);
}

const host::experiments::Limit& limit_of(const host::experiments::Findings& findings, const std::string& what) {
  for (const auto& l : findings.limits)
    if (l.what.find(what) != std::string::npos) return l;
  TEST_FAIL_MESSAGE(("no limit: " + what).c_str());
  return findings.limits.front();
}

/// What did not show may be missing, but must not be taken for something else.
void only_what_is_visible_must_be_named() {
  const Json none = Json::object();
  const std::string named = "one visible effect: share named", wrong = "one effect, visible or not: false names";
  std::vector<host::experiments::CellResult> cells = {
      cell("one", {"time_offset"}, none, answer("explained", {"time_offset"})),
      cell("one", {"gyro_lag"}, none, answer("consistent", {}))};
  TEST_ASSERT_TRUE(limit_of(host::experiments::hidden_gather(cells), named).met());
  cells.push_back(cell("one", {"gyro_lag"}, none, answer("explained", {"time_offset"})));
  TEST_ASSERT_TRUE(limit_of(host::experiments::hidden_gather(cells), named).met());
  TEST_ASSERT_FALSE(limit_of(host::experiments::hidden_gather(cells), wrong).met());
  cells.push_back(cell("one", {"time_offset"}, none, answer("unexplained", {})));
  TEST_ASSERT_FALSE(limit_of(host::experiments::hidden_gather(cells), named).met());
  cells = {cell("one", {"calibration_shift"}, none,
                answer("consistent", {}))};  // without a score statistic: always asked for
  TEST_ASSERT_FALSE(limit_of(host::experiments::hidden_gather(cells), named).met());
}

/// The gap counts whether a name was given or not.
void the_gap_of_what_has_no_name_counts() {
  const Json none = Json::object();
  std::vector<host::experiments::CellResult> cells(
      2, cell("one", {"time_offset"}, none, answer("explained", {"time_offset"})));
  TEST_ASSERT_TRUE(limit_of(host::experiments::hidden_gather(cells), "median").met());
  Json open = answer("unexplained", {});
  open["gap_closed"] = 0.2;
  cells.insert(cells.end(), 3, cell("one", {"time_offset"}, none, open));
  TEST_ASSERT_FALSE(limit_of(host::experiments::hidden_gather(cells), "median").met());
}

void limits_follow_from_the_answers() {
  const Json none = Json::object();
  std::vector<host::experiments::CellResult> cells;
  for (int k = 0; k < 200; ++k)
    cells.push_back(cell("none", {}, none,
                         answer(k < 1 ? "explained" : "consistent",
                                k < 1 ? std::vector<std::string>{"gyro_lag"} : std::vector<std::string>{})));
  cells.push_back(cell("outside", {"outside:gyro_hysteresis"}, none, answer("unexplained", {})));
  cells.push_back(cell("outside", {"outside:gyro_hysteresis"}, none, answer("explained", {"unlisted"})));
  TEST_ASSERT_TRUE(limit_of(host::experiments::hidden_gather(cells), "no effect").met());
  TEST_ASSERT_TRUE(limit_of(host::experiments::hidden_gather(cells), "outside: share").met());
  cells.push_back(cell("none", {}, none, answer("explained", {"gyro_lag"})));
  TEST_ASSERT_FALSE(limit_of(host::experiments::hidden_gather(cells), "no effect").met());
  cells.push_back(cell("outside", {"outside:gyro_hysteresis"}, none, answer("explained", {"gyro_lag"})));
  TEST_ASSERT_FALSE(limit_of(host::experiments::hidden_gather(cells), "outside: false names").met());
  cells.push_back(cell("outside", {"outside:gyro_hysteresis"}, none, answer("consistent", {})));
  TEST_ASSERT_FALSE(limit_of(host::experiments::hidden_gather(cells), "outside: share").met());
}

/// The best fov lens for a radtan one is near it, and for a fov one it is that one.
void a_lens_is_described_by_another_model() {
  host::CameraCalibration camera;
  camera.model = host::DistortionModel::radtan;
  camera.width = 752;
  camera.height = 480;
  camera.intrinsics = {458.654, 457.296, 367.215, 248.375};
  camera.distortion = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  const host::CameraCalibration fov = host::experiments::as_fov(camera);
  TEST_ASSERT_TRUE(fov.model == host::DistortionModel::fov);
  const double off = host::experiments::lens_difference(fov, camera);
  TEST_ASSERT_TRUE(off > 0.1 && off < 3);  // px: wrong enough to be seen, right enough to start from
  const host::CameraCalibration same = host::experiments::as_fov(fov);
  TEST_ASSERT_DOUBLE_WITHIN(1e-5, fov.distortion[0],
                            same.distortion[0]);  // the inversion of the lens stops at 1e-7 or so
}

}  // namespace

void setUp() {}
void tearDown() {}

int main() {
  UNITY_BEGIN();
  RUN_TEST(cases_are_complete_and_reproducible);
  RUN_TEST(saturation_clips_in_every_session);
  RUN_TEST(right_and_wrong_answers_are_told_apart);
  RUN_TEST(only_what_is_visible_must_be_named);
  RUN_TEST(the_gap_of_what_has_no_name_counts);
  RUN_TEST(limits_follow_from_the_answers);
  RUN_TEST(a_lens_is_described_by_another_model);
  return UNITY_END();
}
