// Motion that cannot tell everything is refused where it cannot:
// named directions, values that stay, no false certainty.
#include <unity.h>

#include <algorithm>
#include <string>
#include <vector>

#include "../support/cases.h"
#include "replay/words.h"
#include "simulated_replay.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

struct Case {
  const char* scenario;
  const char* status;              ///< what must come out; empty: anything but `failed`
  std::vector<std::string> blind;  ///< each must be a main part of a direction that is named
  std::vector<std::string> fixed;  ///< each must stay where it was
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      // The camera looks along x of the IMU: turning about the IMU moves it, but nothing gives the size of that motion.
      {"rotation", "", {"cam0.p_CI.x"}, {"cam0.p_CI.x"}},
      // Neither turning nor accelerating: all of the IMU's calibration and the extrinsics stay.
      {"line",
       "insufficient",
       {"gyro.sx", "gyro.sy", "gyro.sz", "accel.sx", "accel.sz", "cam0.p_CI.x", "cam0.p_CI.y", "cam0.p_CI.z"},
       {"gyro.sx", "gyro.sy", "gyro.sz", "accel.sz", "cam0.p_CI.x", "cam0.p_CI.y", "cam0.p_CI.z"}},
      // Turning about z only: scales and misalignments of x and y rates, and the lever arm along z of the IMU, C's -y.
      {"planar",
       "insufficient",
       {"cam0.p_CI.y", "gyro.sx", "gyro.sy", "gyro.mx", "accel.sz"},
       {"cam0.p_CI.y", "gyro.sx", "gyro.sy", "gyro.mx", "accel.sz"}},
  };
  return all;
}

bool contains(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

/// Names with at least a fifth of the weight of some direction that is not excited.
std::vector<std::string> named_blind(const std::vector<host::CoreDirection>& directions,
                                     const std::vector<std::string>& names) {
  std::vector<std::string> out;
  for (const host::CoreDirection& d : directions) {
    for (const auto& [name, weight] : host::main_weights(d, names)) out.push_back(name);
  }
  return out;
}

/// What is released is observed or weak and right within its sigma; what is not stays to the last digit.
void check_parameters(const Id& id, const host::SimulationResult& session, const host::CoreResult& result,
                      const std::vector<std::string>& fixed) {
  const auto errors = test::normalised_errors(session, result);
  for (const host::CoreParameter& p : result.parameters) {
    const Id one = id.add("parameter", p.name);
    if (p.verdict == "fixed") test::check_near(one, "a fixed value", p.initial, p.value, 1e-6);
    if (p.verdict == "observed")
      test::check_between(one, "sigma of an observed value", 0, p.sigma, 0.31 * p.prior_sigma);
    if (p.verdict != "fixed") test::check_between(one, "error / sigma", -5, errors.at(p.name), 5);
    if (contains(fixed, p.name)) test::check_true(one, ("released as " + p.verdict).c_str(), p.verdict == "fixed");
  }
}

void test_poor_motion_is_refused_in_part() {
  for (const Case& c : cases()) {
    const Id id = Id().add("scenario", c.scenario);
    if (!test::selected(id.text())) continue;
    const host::SimulationResult session = test::simulated(c.scenario, 30, 1);
    const host::ReplayResult replay = test::replayed(session);
    std::printf("%s: %s, chi2/dof %.3f, %zu directions not excited\n", c.scenario, replay.result.status.c_str(),
                replay.result.chi2 / std::max(1.0, replay.result.dof), replay.result.unobservable.size());
    test::check_true(id, ("status " + replay.result.status).c_str(),
                     *c.status ? replay.result.status == c.status : replay.result.status != "failed");
    const auto named = named_blind(replay.result.unobservable, host::parameter_names(replay.calibration));
    for (const std::string& name : c.blind)
      test::check_true(id.add("parameter", name), "not named as blind", contains(named, name));
    check_parameters(id, session, replay.result, c.fixed);
  }
}

void test_standing_still_gives_nothing() {
  const host::SimulationResult session = test::simulated("still", 30, 1);
  const host::ReplayResult replay = test::replayed(session);
  const Id id = Id().add("scenario", "still");
  test::check_true(id, "no segment was scored", !replay.segments.empty());
  for (const host::CoreSegment& s : replay.segments) {
    test::check_true(id.add("segment", s.serial), "kept", !s.kept);
    // fov: 11 + 15 entries of theta, all of them blind.
    test::check_between(id.add("segment", s.serial), "directions named", 26, static_cast<double>(s.not_excited.size()),
                        26);
  }
  test::check_true(id, ("status " + replay.result.status).c_str(), replay.result.status == "insufficient");
  test::check_true(id, "the calibration was changed",
                   replay.calibration.cameras[0].intrinsics == session.nominal.cameras[0].intrinsics);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_standing_still_gives_nothing);
  RUN_TEST(test_poor_motion_is_refused_in_part);
  return UNITY_END();
}
