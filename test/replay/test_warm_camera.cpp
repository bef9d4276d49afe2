// A running device whose camera is at another temperature than 25 degC, with the effect's values known: the odometry
// runs with the camera of now, segments are built with the one at 25 degC.
#include <unity.h>

#include "../support/cases.h"
#include "replay/model_file.h"
#include "simulate/effect_names.h"
#include "simulated_replay.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

constexpr char kParameters[][3] = {"rx", "ry", "rz", "f", "cx", "cy"};
/// rad/degC and 1/degC: at 15 degC above, 17 mrad of rotation, far more than the filter's extrinsics are off by.
constexpr double kValues[] = {1e-3, -5e-4, 2e-4, 3e-4, 2e-4, -3e-4};
constexpr double kCelsius = 40;

host::SimulationResult warm_session(std::uint64_t seed) {
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = 40;
  options.seed = seed;
  options.temperature = host::sim::WarmUp{kCelsius, kCelsius};
  std::string spec = "camera_temperature=";
  for (double v : kValues) spec += std::to_string(v) + ",";
  spec.pop_back();
  options.effects = {host::sim::parse_effect(spec)};
  return host::simulate(options);
}

/// The rows' own best step of the sensors from where the segments were built, the effect's values as they are (at one
/// temperature they are not told from the camera's). No calibration has run.
Eigen::VectorXd step_wanted(const host::CoreRows& rows) {
  const int n = rows.n_theta, columns = n + rows.n_candidates + 1;
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd d(n);
  std::size_t at = 0;
  for (int i = 0; i < n; ++i) {
    for (int c = i; c < columns; ++c, ++at) {
      if (c < n) R(i, c) = rows.triangle[at];
    }
    d(i) = rows.triangle[at - 1];
  }
  const Eigen::MatrixXd sensors = R.leftCols(n - 6);
  return (sensors.transpose() * sensors).ldlt().solve(sensors.transpose() * d);
}

/// `held`: the filter runs with the camera that it is given; else it finds the camera of now, whatever it begins with.
void check_segments(bool held) {
  for (std::uint64_t seed : {3, 4}) {
    const Id id = Id().add("held", held ? 1 : 0).add("seed", seed);
    if (!test::selected(id.text())) continue;
    const host::SimulationResult session = warm_session(seed);
    host::ReplayOptions options;
    std::unique_ptr<host::Core> core;
    options.core.calibration = session.truth;
    options.core.noise = session.recording.imu.noise;
    options.core.has_temperature = true;
    options.core.hold_calibration = held;
    options.calibrate = false;
    options.keep_core = &core;
    host::EffectChoice choice;
    choice.enable("camera_temperature");
    for (int i = 0; i < 6; ++i) choice.set(std::string("camera_temperature.") + kParameters[i], kValues[i]);
    choice.apply(&options.core);
    const host::ReplayResult out = host::replay({session.recording}, options);
    // all of 400 frames but those that the start needs
    test::check_between(id, "frames tracked", 350, out.trajectory.size(), 401);
    std::vector<std::uint32_t> serials;
    for (const host::CoreKept& k : core->kept()) serials.push_back(k.segment.serial);
    TEST_ASSERT_GREATER_THAN_INT(3, static_cast<int>(serials.size()));
    const Eigen::VectorXd step = step_wanted(core->linearise(serials, {}));
    for (int i = 0; i < 4; ++i) {
      // The filter knows them to a third of a pixel; f that is not taken back is 1.2 px, cx 0.8, cy 1.2.
      test::check_between(id.add("entry", 6 + i), "fx fy cx cy [px]", -0.5, step(6 + i), 0.5);
    }
    for (int i = 0; i < 3; ++i) {
      // The filter knows r_CI to a milliradian or two; a turn that is not taken back is 17.
      test::check_between(id.add("entry", i), "r_CI [rad]", -4e-3, step(i), 4e-3);
      std::printf("%s: r_CI %d off by %.2g mrad\n", id.text().c_str(), i, 1e3 * step(i));
    }
  }
}

void test_segments_have_the_camera_at_25_degC() {
  check_segments(false);
  check_segments(true);
}

/// The joint filter has no model of it.
void test_joint_filter_refuses() {
  host::CoreOptions options;
  options.calibration = warm_session(3).nominal;
  options.joint_ekf = true;
  host::EffectChoice choice;
  choice.enable("camera_temperature");
  choice.apply(&options);
  try {
    host::make_core("mobile", options);
    TEST_FAIL_MESSAGE("was taken");
  } catch (const host::InputError& error) {
    TEST_ASSERT_TRUE_MESSAGE(std::string(error.what()).find("--joint-ekf") != std::string::npos, error.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_segments_have_the_camera_at_25_degC);
  RUN_TEST(test_joint_filter_refuses);
  return UNITY_END();
}
