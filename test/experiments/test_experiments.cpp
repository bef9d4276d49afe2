// Studies: they go on where they were stopped, give the same bytes again, and say what failed.
#include <unity.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "../replay/program.h"
#include "../replay/temporary_folder.h"
#include "../support/cases.h"
#include "experiments/datasets.h"
#include "experiments/methods.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"
#include "replay/replay.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

namespace fs = std::filesystem;
using namespace host::experiments;
using test::Id;
using test::text_of;

const Experiment& named(const std::string& name) {
  return *std::find_if(experiments().begin(), experiments().end(),
                       [&name](const Experiment& e) { return name == e.name; });
}

/// A few short cells of the degenerate study.
std::vector<Cell> few_cells() {
  std::vector<Cell> cells;
  for (const char* scenario : {"planar", "line"}) {
    for (int seed = 1; seed <= 2; ++seed) {
      cells.push_back(
          {std::string(scenario) + std::to_string(seed), {{"scenario", scenario}, {"seconds", 15}, {"seed", seed}}});
    }
  }
  return cells;
}

fs::path cell_file(const fs::path& dir, const Cell& cell) { return dir / "cells" / (cell.name + ".json"); }

void test_a_study_is_reproducible() {
  const test::TemporaryFolder one("segcal_study_one"), two("segcal_study_two");
  const auto cells = few_cells();
  run_cells(named("degenerate"), cells, one.path(), 1);
  run_cells(named("degenerate"), cells, two.path(), 3);
  for (const Cell& c : cells) {
    const Id id = Id().add("cell", c.name);
    test::check_true(id, "no result", text_of(cell_file(one.path(), c)).size() > 500);
    test::check_true(id, "another result with other jobs",
                     text_of(cell_file(one.path(), c)) == text_of(cell_file(two.path(), c)));
  }
}

void test_a_study_goes_on_where_it_was() {
  const test::TemporaryFolder scratch("segcal_study");
  auto cells = few_cells();
  run_cells(named("degenerate"), cells, scratch.path(), 2);
  const auto marked = fs::file_time_type::clock::now() - std::chrono::hours(24);
  std::vector<std::string> before;
  for (const Cell& c : cells) before.push_back(text_of(cell_file(scratch.path(), c)));
  test::write_text(cell_file(scratch.path(), cells[1]),
                   before[1].substr(0, before[1].size() / 2));  // torn by a power cut
  fs::remove(cell_file(scratch.path(), cells[2]));
  cells[3].parameters["seed"] = 9;  // another study in the same folder
  for (const Cell& c : cells) {
    if (fs::exists(cell_file(scratch.path(), c))) fs::last_write_time(cell_file(scratch.path(), c), marked);
  }
  const auto results = run_cells(named("degenerate"), cells, scratch.path(), 2);
  const auto untouched = [&](std::size_t i) {
    return fs::last_write_time(cell_file(scratch.path(), cells[i])) == marked;
  };
  test::check_true(Id().add("cell", 0), "run again though it was there", untouched(0));
  test::check_true(Id().add("cell", 1), "a torn file was taken",
                   !untouched(1) && text_of(cell_file(scratch.path(), cells[1])) == before[1]);
  test::check_true(Id().add("cell", 2), "not run again", text_of(cell_file(scratch.path(), cells[2])) == before[2]);
  test::check_true(Id().add("cell", 3), "a result of other parameters was taken",
                   !untouched(3) && results[3].result != host::experiments::Json::parse(before[3])["result"]);
  TEST_ASSERT_EQUAL_UINT(cells.size(), results.size());
}

Json fails_for_two(const Json& parameters) {
  if (parameters.at("k") == 2) throw std::runtime_error("this one is meant to fail");
  return {{"square", parameters.at("k").get<int>() * parameters.at("k").get<int>()}};
}

void test_a_failing_cell_is_named_and_the_others_stay() {
  const test::TemporaryFolder scratch("segcal_failing_study");
  const Experiment failing{"failing", "", false, nullptr, fails_for_two, nullptr};
  std::vector<Cell> cells;
  for (int k = 1; k <= 3; ++k) cells.push_back({"cell" + std::to_string(k), {{"k", k}}});
  std::string complaint;
  try {
    run_cells(failing, cells, scratch.path(), 2);
  } catch (const host::InputError& error) {
    complaint = error.what();
  }
  test::check_true(Id().add("check", "complaint"), complaint.c_str(),
                   complaint.find("1 cells failed, the first is cell2") != std::string::npos);
  test::check_true(Id().add("check", "others"), "lost",
                   fs::exists(cell_file(scratch.path(), cells[0])) && fs::exists(cell_file(scratch.path(), cells[2])));
}

void test_findings_have_units_and_a_page() {
  const test::TemporaryFolder scratch("segcal_findings");
  const Experiment& degenerate = named("degenerate");
  const Findings findings = degenerate.gather(run_cells(degenerate, few_cells(), scratch.path(), 2));
  write_findings(degenerate, findings, {}, scratch.path());
  const std::string csv = text_of(scratch.path() / "degenerate.csv"), page = text_of(scratch.path() / "report.html");
  test::check_true(Id().add("file", "csv"), "no unit in the header",
                   csv.find("largest error [sigma]") < csv.find('\n'));
  // 26 parameters of two motions, and the header.
  test::check_near(Id().add("file", "csv"), "lines", 53, static_cast<double>(std::count(csv.begin(), csv.end(), '\n')),
                   0);
  test::check_true(Id().add("file", "page"), "no table of limits",
                   page.find("blind parameters released, planar") != std::string::npos);
  const Json json = Json::parse(text_of(scratch.path() / "degenerate.json"));
  test::check_true(Id().add("file", "json"), "limits",
                   json.at("limits").size() == findings.limits.size() && !findings.limits.empty());
}

void test_the_command() {
  const test::TemporaryFolder scratch("segcal_experiments_command");
  const std::string out = " --out \"" + (scratch.path() / "out").string() + "\"";
  struct Case {
    std::string arguments;
    int code;
    std::string says;
  };
  const std::string rec = "\"" + (scratch.path() / "rec").string() + "\"";
  test::run_program("simulate --scenario rich --seconds 20 --out " + rec, scratch.path());
  for (const Case& c :
       {Case{"experiments --list", 0, "database_size"}, Case{"experiments" + out, 2, "expected a name"},
        Case{"experiments basin", 2, "expected --out DIR"}, Case{"experiments nothing" + out, 2, "found 'nothing'"},
        Case{"experiments basin " + rec + out, 2, "expected no recordings"},
        Case{"experiments sigma_ref " + rec + out, 0, "report.html"},
        Case{"experiments sigma_ref " + rec + out, 0, "1 of 1 cells, 1 were there"}}) {
    const test::Outcome outcome = test::run_program(c.arguments, scratch.path());
    const Id id = Id().add("case", c.arguments);
    test::check_near(id, "exit code", c.code, outcome.code, 0);
    test::check_true(id, ("says: " + outcome.out + outcome.err).c_str(),
                     (outcome.out + outcome.err).find(c.says) != std::string::npos);
  }
}

/// The metrics are of the same covariance as a segment's sigmas: A with sigma_ref the prior's is the sum of squares.
void test_sigmas_of_a_segment_make_its_metric() {
  const host::SimulationResult session = simulate_session(dataset_named("arvr_office_room"), 1, 0, 20);
  host::ReplayOptions options;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  const host::ReplayResult plain = host::replay({session.recording}, options);
  for (const host::CoreParameter& p : plain.result.parameters) options.core.sigma_ref.push_back(2 * p.prior_sigma);
  const host::ReplayResult halved = host::replay({session.recording}, options);
  TEST_ASSERT_GREATER_THAN_UINT(2, plain.segments.size());
  for (std::size_t s = 0; s < plain.segments.size(); ++s) {
    double A = 0;
    for (std::size_t i = 0; i < plain.result.parameters.size(); ++i)
      A += std::pow(plain.segments[s].sigma[i] / plain.result.parameters[i].prior_sigma, 2);
    // float: 26 squares of 7 digits.
    test::check_near(Id().add("segment", s), "A from sigmas", plain.segments[s].A, A, 1e-4 * A);
    test::check_near(Id().add("segment", s), "A against twice the prior", plain.segments[s].A / 4, halved.segments[s].A,
                     1e-4 * A);
  }
}

/// The odometry that holds its calibration shows what that is worth; the one that estimates it hides most of it.
void test_the_true_calibration_serves_odometry_better() {
  double nominal = 0, truth = 0, estimating = 0;
  for (int i = 0; i < 3; ++i) {
    const host::SimulationResult session = simulate_evaluation(1, i, 30);
    nominal += odometry_error(session, session.nominal, Odometry::held).position_m / 3;
    truth += odometry_error(session, session.truth, Odometry::held).position_m / 3;
    estimating += odometry_error(session, session.nominal, Odometry::estimating).position_m / 3;
  }
  std::printf("position RMSE: nominal %.1f mm, true %.1f mm; nominal and estimated %.1f mm\n", 1e3 * nominal,
              1e3 * truth, 1e3 * estimating);
  test::check_between(Id().add("check", "held"), "true / nominal", 0, truth / nominal, 0.5);
  test::check_between(Id().add("check", "estimating"), "estimating / nominal", 0, estimating / nominal, 0.7);
}

void test_statistics() {
  const Id id = Id().add("check", "statistics");
  test::check_near(id, "median", 2.5, median({4, 1, 3, 2}), 1e-15);
  test::check_near(id, "quartile", 2, host::quantile({1, 2, 3, 4, 5}, 0.25), 1e-15);
  test::check_near(id, "deviation", std::sqrt(5.0 / 3), deviation({1, 2, 3, 4}), 1e-15);
  test::check_near(id, "geometric mean", 2, geometric_mean({1, 4}), 1e-15);
  test::check_near(id, "median ratio", 0.5, median_ratio({1, 2, 3}, {2, 4, 3}), 1e-15);
}

void test_methods_are_those_of_the_core() {
  std::vector<std::string> names;
  for (const Method& m : methods()) names.push_back(m.name);
  for (const char* name : {"initial", "batch", "all", "A", "D", "E", "set_d", "random", "condensed", "joint_ekf"}) {
    test::check_true(Id().add("method", name), "not offered",
                     std::find(names.begin(), names.end(), name) != names.end());
  }
  bool refused = false;
  try {
    method_named("no such method");
  } catch (const host::InputError&) {
    refused = true;
  }
  test::check_true(Id().add("method", "unknown"), "not refused", refused);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_a_study_is_reproducible);
  RUN_TEST(test_a_study_goes_on_where_it_was);
  RUN_TEST(test_a_failing_cell_is_named_and_the_others_stay);
  RUN_TEST(test_findings_have_units_and_a_page);
  RUN_TEST(test_the_command);
  RUN_TEST(test_sigmas_of_a_segment_make_its_metric);
  RUN_TEST(test_the_true_calibration_serves_odometry_better);
  RUN_TEST(test_statistics);
  RUN_TEST(test_methods_are_those_of_the_core);
  return UNITY_END();
}
