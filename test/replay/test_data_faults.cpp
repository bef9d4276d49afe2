// Faults in the data of a log: counted in result.json, survived, and never worse than the motion they cost.
#include <unity.h>

#include <cstdio>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "../support/cases.h"
#include "program.h"
#include "simulate/device.h"
#include "simulate/simulate.h"
#include "temporary_folder.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

namespace fs = std::filesystem;
using host::ImuSample;
using host::Recording;
using test::Id;

fs::path scratch;
host::SimulationResult session;

struct Case {
  const char* name;
  std::function<void(Recording*)> spoil;
  const char* counter;  ///< in result.json, "faults"
  unsigned count;       ///< exactly
};

std::vector<ImuSample>& imu(Recording* r) { return r->imu.samples; }
std::vector<host::Frame>& frames(Recording* r) { return r->cameras[0].frames; }

/// From the end, so that earlier places keep their numbers.
constexpr std::size_t kPlaces[] = {5000, 3300, 1700};

std::vector<Case> cases() {
  return {
      {"imu_repeats",
       [](Recording* r) {
         for (std::size_t i : kPlaces) imu(r).insert(imu(r).begin() + long(i), imu(r)[i]);
       },
       "imu_stamps_back", 3},
      {"imu_goes_back",
       [](Recording* r) {
         for (std::size_t i : kPlaces) imu(r).insert(imu(r).begin() + long(i), imu(r)[i - 9]);
       },
       "imu_stamps_back", 3},
      {"imu_gaps",
       [](Recording* r) {
         for (std::size_t i : kPlaces) imu(r).erase(imu(r).begin() + long(i), imu(r).begin() + long(i) + 5);
       },
       "imu_gaps", 3},
      {"imu_nan",
       [](Recording* r) {
         for (std::size_t i : kPlaces) imu(r)[i].gyro[1] = std::numeric_limits<double>::quiet_NaN();
       },
       "imu_not_finite", 3},
      {"imu_infinite",
       [](Recording* r) {
         for (std::size_t i : kPlaces) imu(r)[i].accel[2] = std::numeric_limits<double>::infinity();
       },
       "imu_not_finite", 3},
      {"imu_saturates",
       [](Recording* r) {
         for (std::size_t i : kPlaces) imu(r)[i].accel[0] = 160;
       },
       "imu_saturated", 3},
      {"frame_repeats",
       [](Recording* r) {
         for (std::size_t i : kPlaces) frames(r).insert(frames(r).begin() + long(i / 20), frames(r)[i / 20]);
       },
       "frame_stamps_back", 3},
      {"frame_goes_back",
       [](Recording* r) {
         for (std::size_t i : kPlaces) frames(r).insert(frames(r).begin() + long(i / 20), frames(r)[i / 20 - 4]);
       },
       "frame_stamps_back", 3},
      {"frame_dropped",
       [](Recording* r) {
         for (std::size_t i : kPlaces) frames(r).erase(frames(r).begin() + long(i / 20));
       },
       "frames_dropped", 3},
      {"few_tracks",
       [](Recording* r) {
         for (std::size_t i : kPlaces) frames(r)[i / 20].points.resize(7);
       },
       "frames_few_tracks", 3},
      {"point_nan",
       [](Recording* r) {
         for (std::size_t i : kPlaces) frames(r)[i / 20].points[3].u = std::numeric_limits<double>::quiet_NaN();
       },
       "points_not_finite", 3},
  };
}

nlohmann::json replayed(const Id& id, const Recording& recording) {
  const fs::path rec = scratch / "rec", out = scratch / "out";
  fs::remove_all(rec);
  fs::remove_all(out);
  host::SimulationResult spoilt = session;
  spoilt.recording = recording;
  host::write_simulation(spoilt, rec);
  const test::Outcome outcome =
      test::run_program("replay \"" + rec.string() + "\" --out \"" + out.string() + "\"", scratch);
  test::check_true(id, ("ended with " + std::to_string(outcome.code) + ": " + outcome.err).c_str(), outcome.code == 0);
  return nlohmann::json::parse(test::text_of(out / "result.json"));
}

/// No count where nothing was spoilt; otherwise exactly what was done to the data.
void test_faults_are_counted_and_survived() {
  const nlohmann::json good = replayed(Id().add("case", "good"), session.recording);
  for (const Case& c : cases()) TEST_ASSERT_EQUAL_UINT_MESSAGE(0, good["faults"][c.counter], c.counter);
  for (const Case& c : cases()) {
    const Id id = Id().add("case", c.name);
    if (!test::selected(id.text())) continue;
    Recording recording = session.recording;
    c.spoil(&recording);
    const nlohmann::json result = replayed(id, recording);
    test::check_between(id, c.counter, c.count, result["faults"][c.counter], c.count);
    test::check_true(id, "not calibrated", result["status"] == "calibrated");
  }
}

struct Stray {
  const char* name;
  std::vector<std::size_t> images;
  double seconds;  ///< that their stamps are ahead
};

/// An image whose stamp lies apart costs itself, and one that may wait for it: not all that come before its stamp.
void test_stray_images_cost_themselves() {
  const nlohmann::json good = replayed(Id().add("case", "good"), session.recording);
  const Stray all[] = {{"first_ahead", {0}, 3600},
                       {"middle_ahead", {150}, 3600},
                       {"within_the_log", {150}, 10},
                       {"near", {150}, 1.5},
                       {"last_but_one", {299}, 3600},
                       {"last", {300}, 3600},
                       {"handful_in_a_row", {140, 141, 142, 143, 144}, 3600},
                       {"handful", {0, 60, 61, 130, 290}, 7},
                       {"first_behind", {0}, -3600},
                       {"middle_behind", {150}, -3600}};
  for (const Stray& stray : all) {
    const Id id = Id().add("stray", stray.name);
    if (!test::selected(id.text())) continue;
    Recording recording = session.recording;
    for (const std::size_t i : stray.images)
      frames(&recording)[i].t_ns += static_cast<std::int64_t>(stray.seconds * 1e9);
    const nlohmann::json result = replayed(id, recording);
    test::check_true(id, "not calibrated", result["status"] == "calibrated");
    test::check_between(id, "images used", double(good["faults"]["frames_used"]) - 2 * double(stray.images.size()),
                        result["faults"]["frames_used"], 1e9);
    test::check_between(id, "images in all", good["faults"]["frames"], result["faults"]["frames"],
                        good["faults"]["frames"]);
    test::check_between(id, "counted", stray.images.size(), result["faults"]["frame_stamps_far"], stray.images.size());
    if (stray.seconds < 0) continue;
    char time[40];
    std::snprintf(time, sizeof time, "the first at %.3f s",
                  static_cast<double>(frames(&recording)[stray.images.front()].t_ns) * 1e-9);
    test::check_true(id, "no sentence with its time",
                     result["health"]["suspects"].dump().find(time) != std::string::npos);
  }
}

/// The faults together must not make the result wrong: within 5 of its own sigmas, as without them.
void test_faults_do_not_bend_the_result() {
  const Id id = Id().add("case", "all");
  Recording recording = session.recording;
  for (const Case& c : cases()) {
    if (std::string(c.name) != "imu_gaps") c.spoil(&recording);  // these would split each stretch three more times
  }
  const nlohmann::json result = replayed(id, recording);
  std::map<std::string, double> truth;
  for (const auto& p : host::sim::named_parameters(session.truth, true)) truth[p.name] = p.value;
  for (const auto& p : result["parameters"]) {
    const std::string name = p["name"];
    test::check_between(id.add("parameter", name), "error / sigma", -5,
                        (double(p["value"]) - truth.at(name)) / double(p["sigma"]), 5);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  const test::TemporaryFolder folder("segcal_test_data_faults");
  scratch = folder.path();
  host::SimulationOptions options;
  options.seconds = 30;
  session = host::simulate(options);
  UNITY_BEGIN();
  RUN_TEST(test_faults_are_counted_and_survived);
  RUN_TEST(test_stray_images_cost_themselves);
  RUN_TEST(test_faults_do_not_bend_the_result);
  return UNITY_END();
}
