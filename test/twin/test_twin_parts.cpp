// The parts of a recording's twin: its motion, what it takes over, and what of a diagnosis it has a model of.
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "../support/cases.h"
#include "diagnose/fault.h"
#include "replay/replay.h"
#include "simulate/effect_names.h"
#include "simulate/simulate.h"
#include "twin/make.h"
#include "twin/motion.h"
#include "twin/twin_folder.h"
#include "twin/twin_report.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using Eigen::Vector3d;

host::SimulationResult session_of(const char* scenario, double seconds, std::uint64_t seed) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = seconds;
  options.seed = seed;
  return host::simulate(options);
}

/// Rates and accelerations of the twin's motion are the true ones to twice what they are found to be, which is less
/// than the poses of the odometry alone have by their jumps of a millimetre at 10 images/s (0.3 m/s^2).
void test_motion_of_a_recording_is_the_true_one() {
  const host::SimulationResult session = session_of("rich", 20, 3);
  host::ReplayOptions options;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  const host::ReplayResult fit = host::replay({session.recording}, options);
  const host::sim::PoseSeries poses = host::twin::motion_of(session.recording, fit);
  TEST_ASSERT_TRUE(!poses.t.empty() && poses.t.back() > 14);
  const host::sim::Trajectory motion = host::sim::fit_trajectory(poses, "test", 0.025).trajectory;
  double w2 = 0, a2 = 0, p2 = 0, n = 0;
  for (double t = 1; t < poses.t.back() - 1; t += 0.01, ++n) {
    const host::sim::BodyState truth = session.state_at(poses.first_ns + std::llround(1e9 * t)).body,
                               twin = motion.at(t);
    w2 += (twin.w_GI - truth.w_GI).squaredNorm();
    // each in its own attitude: yaw and place of the odometry's world are free
    a2 += (twin.R_GI.transpose() * twin.a_GI - truth.R_GI.transpose() * truth.a_GI).squaredNorm();
    const host::sim::BodyState truth_later = session.state_at(poses.first_ns + std::llround(1e9 * (t + 0.9))).body,
                               later = motion.at(t + 0.9);
    p2 += (twin.R_GI.transpose() * (later.p_GI - twin.p_GI) - truth.R_GI.transpose() * (truth_later.p_GI - truth.p_GI))
              .squaredNorm();
  }
  TEST_ASSERT_DOUBLE_WITHIN(0.03, 0, std::sqrt(w2 / n));
  TEST_ASSERT_DOUBLE_WITHIN(0.05, 0, std::sqrt(p2 / n));  // m over 0.9 s: integrated without the poses it drifts
  TEST_ASSERT_DOUBLE_WITHIN(0.2, 0, std::sqrt(a2 / n));
}

/// A turn through straight up, which Euler angles cannot follow: attitude and rate are those of the poses.
void test_recorded_attitudes_have_no_pole() {
  host::sim::PoseSeries poses;
  const Vector3d axis = Vector3d(0.2, 1, 0.1).normalized();
  for (int i = 0; i <= 1000; ++i) {
    const double t = 0.005 * i;
    poses.t.push_back(t);
    poses.p_GI.emplace_back(0, 0, 0);
    poses.R_GI.push_back(Eigen::AngleAxisd(1.3 * t, axis).toRotationMatrix());
  }
  const host::sim::Trajectory motion = host::sim::fit_trajectory(poses, "test", 0.05).trajectory;
  for (double t = 0.2; t < 4.8; t += 0.1) {
    const host::sim::BodyState x = motion.at(t);
    const Eigen::Matrix3d off = x.R_GI.transpose() * Eigen::AngleAxisd(1.3 * t, axis).toRotationMatrix();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0, Eigen::AngleAxisd(off).angle());  // of a spline with 50 knots a turn
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0, (x.w_GI - 1.3 * axis).norm());    // rad/s
  }
}

/// k r^6 with this k folds the image back inside of its edge: rays from behind the fold would move against all others,
/// which the check of tracks called a fault of the tracker (18 % of the corners).
void test_a_lens_ends_where_it_folds_back() {
  host::SimulationOptions options;
  options.scenario = "arvr";
  options.seconds = 30;
  options.seed = 5;
  options.effects.push_back(host::sim::parse_effect("outside:decentred_distortion=-0.06,0.2,-0.15"));
  const host::SimulationResult session = host::simulate(options);
  for (const host::Fault& f : host::find_faults(session.recording, session.nominal))
    TEST_ASSERT_TRUE_MESSAGE(f.is_remark(), f.words.c_str());
}

/// A lens that bends inwards shows points that its model has outside of the image; none is outside after all.
void test_bent_lens_fills_the_image() {
  constexpr double k = -0.05;
  host::SimulationOptions options;
  options.seconds = 10;
  options.device_scale = 0;
  options.tracks.pixel_noise_px = 0;
  options.effects.push_back(host::sim::parse_effect("radial_residual=-0.05"));
  const host::SimulationResult session = host::simulate(options);
  const host::CameraCalibration& camera = session.truth.cameras.front();
  const auto is_inside = [&camera](const Eigen::Vector2d& p) {
    return p.x() >= 3 && p.x() <= camera.width - 4 && p.y() >= 3 && p.y() <= camera.height - 4;
  };
  int outside = 0;
  for (const host::Frame& frame : session.recording.cameras.front().frames) {
    for (const host::TrackPoint& p : frame.points) {
      TEST_ASSERT_TRUE(is_inside({p.u, p.v}));
      const Eigen::Vector2d bent =
          (Eigen::Vector2d(p.u, p.v) - camera.intrinsics.tail<2>()).cwiseQuotient(camera.intrinsics.head<2>());
      Eigen::Vector2d ideal = bent;
      for (int i = 0; i < 100; ++i) ideal = bent / (1 + k * ideal.squaredNorm());  // contracts: 3 k r^2 < 0.4
      outside += !is_inside(ideal.cwiseProduct(camera.intrinsics.head<2>()) + camera.intrinsics.tail<2>());
    }
  }
  TEST_ASSERT_GREATER_THAN_INT(100, outside);  // of some 6000
}

host::DiagnosedEffect effect(const char* name, const std::vector<std::pair<const char*, double>>& parameters) {
  host::DiagnosedEffect out;
  out.name = name;
  out.words = "a sentence";
  for (const auto& [parameter, value] : parameters) out.parameters.push_back({parameter, value, 0.1, "-"});
  return out;
}

/// Stated offsets are taken off, times count from the twin's own beginning, and what has no model is said.
void test_effects_as_the_simulator_takes_them() {
  const host::SimulationResult session = session_of("rich", 5, 1);
  host::DiagnoseOptions options;
  options.core.calibration = session.nominal;
  options.core.calibration.cameras.front().timeshift_cam_imu = 0.002;
  options.stamp_exposure = 0.5;
  host::Diagnosis found;
  found.effects = {
      effect("time_offset", {{"time_offset.t_d", 0.005}}),
      effect("calibration_shift",
             {{"calibration_shift.time", 12}, {"calibration_shift.cam0.c.x", 3}, {"calibration_shift.cam0.c.y", -1}}),
      effect("exposure_offset", {{"exposure_offset.kappa", 0.7}}),
      effect("unlisted", {{"gyro_x:fy*wz", 1}}),
      effect("gyro_lag", {{"gyro_lag.tau", -0.001}}),
      effect("imu_noise", {{"gyro_noise.factor", 7}})};
  found.pixels.factor = 0.8;  // of 0.5 px; nothing says that tracks drift
  found.raw_noise.gyro.factor = 2;
  found.raw_noise.gyro.verdict = host::SensorNoise::Verdict::above;
  found.raw_noise.accel.factor = 9;  // motion fills the band: not known
  host::SimulationOptions plain;
  plain.replica.emplace();
  plain.replica->poses.first_ns = session.recording.cameras.front().frames.front().t_ns + 2'000'000'000;
  host::twin::Comparison said;
  const host::SimulationOptions with = host::twin::with_effects(plain, session.recording, found, options, &said);
  TEST_ASSERT_EQUAL_INT(5, static_cast<int>(said.effects.size()));
  TEST_ASSERT_EQUAL_STRING("time_offset=0.003", said.effects[0].c_str());
  TEST_ASSERT_EQUAL_STRING("calibration_shift=cam0.c,10,3,-1", said.effects[1].c_str());
  TEST_ASSERT_EQUAL_STRING("exposure_offset=0.2", said.effects[2].c_str());
  TEST_ASSERT_EQUAL_STRING("corners of 0.4 px and 0 px/sqrt(s)", said.effects[3].c_str());
  TEST_ASSERT_EQUAL_STRING("imu_noise=2,1", said.effects[4].c_str());
  TEST_ASSERT_EQUAL_INT(4, static_cast<int>(with.effects.size()));
  TEST_ASSERT_EQUAL_INT(2, static_cast<int>(said.not_simulated.size()));
  TEST_ASSERT_EQUAL_STRING("a sentence", said.not_simulated[0].c_str());
  TEST_ASSERT_EQUAL_STRING("gyro_lag", said.not_simulated[1].c_str());  // a lag is never negative
}

/// A mean of a device that changed is put back to what it was before.
void test_device_before_a_step() {
  host::Diagnosis found;
  found.effects = {
      effect("calibration_shift",
             {{"calibration_shift.time", 12}, {"calibration_shift.cam0.c.x", 3}, {"calibration_shift.cam0.c.y", -1}})};
  found.before_step = {-1.5, 0.5};
  host::Calibration device = session_of("rich", 1, 1).nominal;
  const Eigen::Vector4d before = device.cameras.front().intrinsics;
  host::twin::put_before_step(found, &device);
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, before[2] - 1.5, device.cameras.front().intrinsics[2]);
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, before[3] + 0.5, device.cameras.front().intrinsics[3]);
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, before[0], device.cameras.front().intrinsics[0]);
}

void test_recorded_conditions_are_taken_over() {
  host::sim::WarmUp course;
  course.measured = {{0, 20}, {10, 30}, {20, 30}};
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 25, course.at(5));
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 20, course.at(-3));
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 30, course.at(99));
  const std::vector<std::pair<double, double>> exposures = {{0, 0.002}, {0.1, 0.004}};
  TEST_ASSERT_EQUAL_DOUBLE(0.002, host::sim::latest(exposures, -1));
  TEST_ASSERT_EQUAL_DOUBLE(0.002, host::sim::latest(exposures, 0.05));
  TEST_ASSERT_EQUAL_DOUBLE(0.004, host::sim::latest(exposures, 0.1));
}

/// Within chance nothing is said to be left, and no figure is made of a difference that is none.
void test_what_is_left_counts_from_chance_on() {
  host::twin::Comparison c;
  c.statistics = {{"seen", "px", 2, 0.1, 1, 1.75}, {"unseen", "-", 1, 0.5, 0, 5}, {"unknown", "-", 1, 0, 0, 5}};
  TEST_ASSERT_TRUE(c.statistics[0].differs());
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.25, c.statistics[0].left());
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.1 * std::sqrt(2.0), c.statistics[0].left_sigma());
  TEST_ASSERT_FALSE(c.statistics[1].differs());
  TEST_ASSERT_FALSE(c.statistics[2].differs());  // nothing is known of what chance does to it
  const auto json = nlohmann::json::parse(host::twin::as_json(c));
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.25, json.at("statistics")[0].at("left").get<double>());
  TEST_ASSERT_TRUE(json.at("statistics")[1].at("left").is_null());
  c.why_not = "no motion";
  TEST_ASSERT_EQUAL_STRING("no twin: no motion\n", host::twin::as_table(c).c_str());
}

/// A twin never falls on what is read, nor on the diagnosis; where it ends, nothing of an earlier one is left.
void test_folder_of_its_own() {
  namespace fs = std::filesystem;
  const fs::path root = fs::temp_directory_path() / ("segcal_test_twin_" + std::to_string(getpid()));
  const fs::path rec = root / "rec", out = root / "d", twin = root / "twin";
  fs::create_directories(rec / "mav0");
  for (const fs::path& wrong : {rec, rec / "t", root, out, out / "t", fs::path(rec.string() + "/../rec")}) {
    bool refused = false;
    try {
      host::twin::expect_twin_folder(wrong, {out, rec});
    } catch (const host::InputError&) {
      refused = true;
    }
    TEST_ASSERT_TRUE_MESSAGE(refused, wrong.c_str());
  }
  host::SimulationOptions options;
  options.seconds = 1;
  options.exposures = true;
  host::twin::expect_twin_folder(twin, {out, rec});
  host::twin::write_twin(host::simulate(options), twin);
  TEST_ASSERT_TRUE(fs::exists(twin / "mav0/cam0/exposure.csv") && fs::exists(twin / "manifest.json"));
  options.exposures = false;
  host::twin::expect_twin_folder(twin, {out, rec});
  host::twin::write_twin(host::simulate(options), twin);
  TEST_ASSERT_FALSE(fs::exists(twin / "mav0/cam0/exposure.csv"));
  fs::remove_all(root);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_motion_of_a_recording_is_the_true_one);
  RUN_TEST(test_recorded_attitudes_have_no_pole);
  RUN_TEST(test_bent_lens_fills_the_image);
  RUN_TEST(test_a_lens_ends_where_it_folds_back);
  RUN_TEST(test_effects_as_the_simulator_takes_them);
  RUN_TEST(test_device_before_a_step);
  RUN_TEST(test_recorded_conditions_are_taken_over);
  RUN_TEST(test_what_is_left_counts_from_chance_on);
  RUN_TEST(test_folder_of_its_own);
  return UNITY_END();
}
