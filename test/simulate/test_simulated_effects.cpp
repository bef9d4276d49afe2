// Effects of the simulator against what they are in nature: a sensor elsewhere, an equation, a shifted clock.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "../replay/temporary_folder.h"
#include "../support/cases.h"
#include "file_output.h"
#include "simulate/camera_simulator.h"
#include "simulate/device.h"
#include "simulate/effect_model.h"
#include "simulate/effect_names.h"
#include "simulate/effects_camera.h"
#include "simulate/effects_imu.h"
#include "simulate/scenarios.h"
#include "simulate/simulate.h"
#include "unity.h"

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

host::SimulationOptions session(double seconds = 4) {
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = seconds;
  options.seed = 11;
  return options;
}

host::SimulationResult simulated(const std::string& effect, double seconds = 4) {
  host::SimulationOptions options = session(seconds);
  if (!effect.empty()) options.effects.push_back(host::sim::parse_effect(effect));
  return host::simulate(options);
}

Vector3d gyro(const host::ImuSample& sample) { return Vector3d(sample.gyro[0], sample.gyro[1], sample.gyro[2]); }
Vector3d accel(const host::ImuSample& sample) { return Vector3d(sample.accel[0], sample.accel[1], sample.accel[2]); }

/// The largest difference of any value or stamp; counts that differ are infinite.
double difference(const host::Recording& a, const host::Recording& b) {
  if (a.imu.samples.size() != b.imu.samples.size()) return INFINITY;
  double largest = 0;
  for (std::size_t k = 0; k < a.imu.samples.size(); ++k) {
    const auto &x = a.imu.samples[k], &y = b.imu.samples[k];
    largest = std::max({largest, std::abs(static_cast<double>(x.t_ns - y.t_ns)), (gyro(x) - gyro(y)).norm(),
                        (accel(x) - accel(y)).norm(), std::abs(x.temperature_degC - y.temperature_degC)});
  }
  for (std::size_t f = 0; f < a.cameras[0].frames.size(); ++f) {
    const auto &x = a.cameras[0].frames[f], &y = b.cameras[0].frames[f];
    if (x.points.size() != y.points.size()) return INFINITY;
    largest = std::max(largest, std::abs(static_cast<double>(x.t_ns - y.t_ns)));
    for (std::size_t i = 0; i < x.points.size(); ++i)
      largest = std::max({largest, std::abs(x.points[i].u - y.points[i].u), std::abs(x.points[i].v - y.points[i].v)});
  }
  return largest;
}

/// With the example of --help; of 32 s, so that the shock and the frozen sensor come within it.
void every_effect_changes_the_recording_and_says_what_it_is() {
  const auto plain = simulated("", 32);
  for (const auto& entry : host::sim::effect_entries()) {
    const test::Id id = test::Id().add("effect", entry.name);
    if (!test::selected(id.text())) continue;
    const std::string text = std::string(entry.name) + "=" + entry.example;
    const auto with = simulated(text, 32);
    test::check_true(id, "changes the recording", difference(plain.recording, with.recording) > 1e-5);
    test::check_true(id, "says what it is", with.effects.size() == 1 && !with.effects[0].name.empty());
  }
}

host::sim::Trajectory motion() { return host::sim::make_trajectory("rich", 10, 4); }

host::sim::ImuReading change(const host::sim::Effect& effect, const host::sim::Trajectory& truth, double t,
                             const host::ImuCalibration& imu = {}) {
  const host::sim::BodyState state = truth.at(t);
  const Vector3d force = state.R_GI.transpose() * (state.a_GI - host::sim::gravity_G);
  host::sim::ImuReading reading;
  effect.on_imu({t, truth, imu, state, force, 31}, reading);
  return reading;
}

/// tau dw_m/dt + w_m = w. The derivative of w_m by central differences.
void gyro_lag_is_a_first_order_low_pass() {
  const auto truth = motion();
  for (double tau : {0.001, 0.004, 0.03}) {
    const host::sim::GyroLag lag(tau);
    const auto measured = [&](double t) -> Vector3d { return truth.at(t).w_GI + change(lag, truth, t).gyro; };
    for (double t = 2; t < 8; t += 0.173) {
      const double h = 1e-3;  // h^2/6 w''' is below 1e-3 rad/s^2
      const Vector3d left = tau * (measured(t + h) - measured(t - h)) / (2 * h) + measured(t);
      // Gauss-Laguerre of degree 15 on rates of at most 2 Hz; the spline's knots leave 1e-6 at tau = 30 ms.
      test::check_near(test::Id().add("tau", tau).add("t", t), "left minus right", 0, (left - truth.at(t).w_GI).norm(),
                       1e-4 * tau / 0.004 + 1e-6);
      test::check_true(test::Id().add("tau", tau).add("t", t), "and not the rate itself",
                       change(lag, truth, t).gyro.norm() > 1e-6);
    }
  }
}

/// An accelerometer at r reads the acceleration of its own place, here by differences of its path.
void accel_axis_offset_is_an_accelerometer_elsewhere() {
  const auto truth = motion();
  const Vector3d r_y(0.02, -0.01, 0.03), r_z(-0.015, 0.025, 0.01);
  const host::sim::AccelAxisOffset offset(r_y, r_z);
  const auto place = [&](double t, const Vector3d& r) -> Vector3d { return truth.at(t).R_GI * r; };
  for (double t = 1; t < 9; t += 0.217) {
    const double h = 1e-3;
    const auto extra = [&](const Vector3d& r) -> Vector3d {
      return truth.at(t).R_GI.transpose() * (place(t + h, r) - 2 * place(t, r) + place(t - h, r)) / (h * h);
    };
    const Vector3d added = change(offset, truth, t).accel;
    // h^2/12 of the fourth derivative of the path: 1e-7 * 0.04 m * (12 rad/s)^4 is below 1e-4.
    test::check_near(test::Id().add("t", t), "y", extra(r_y).y(), added.y(), 1e-4);
    test::check_near(test::Id().add("t", t), "z", extra(r_z).z(), added.z(), 1e-4);
    test::check_near(test::Id().add("t", t), "x", 0, added.x(), 0);
  }
}

void terms_on_the_imu_have_the_stated_size() {
  const auto truth = motion();
  const auto state = truth.at(3);
  const Vector3d f = state.R_GI.transpose() * (state.a_GI - host::sim::gravity_G), w = state.w_GI;
  const auto g = change(*host::sim::parse_effect("gyro_g_sensitivity=0,1e-3,0,0,0,0,0,0,-2e-3"), truth, 3).gyro;
  TEST_ASSERT_DOUBLE_WITHIN(1e-15, 1e-3 * f.y(), g.x());
  TEST_ASSERT_DOUBLE_WITHIN(1e-15, -2e-3 * f.z(), g.z());
  const auto n = change(*host::sim::parse_effect("gyro_nonlinearity=0.01,0,0.02"), truth, 3).gyro;
  TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.02 * w.z() * std::abs(w.z()), n.z());
  host::ImuCalibration turned;
  turned.R_AI << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  const auto a = change(*host::sim::parse_effect("accel_nonlinearity=0.01,0,0"), truth, 3, turned).accel;
  TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.01 * f.y() * f.y(), a.x());
  TEST_ASSERT_DOUBLE_WITHIN(1e-15, 6e-4,
                            change(*host::sim::parse_effect("gyro_temperature=0,1e-4,0"), truth, 3).gyro.y());
  TEST_ASSERT_DOUBLE_WITHIN(1e-15, 6e-3,
                            change(*host::sim::parse_effect("accel_temperature=0,0,1e-3"), truth, 3).accel.z());
}

/// The only landmark of a scene as a camera without noise sees it at `t`.
Vector2d seen(const host::sim::Trajectory& truth, const host::sim::Effects& effects, double t,
              bool reads_columns = false) {
  host::Calibration device = host::sim::nominal_device(host::DistortionModel::fov, 1);
  device.cameras[0].reads_columns = reads_columns;
  const host::CameraCalibration& camera = device.cameras[0];
  const auto middle = truth.at(4);
  const Vector3d ahead_C(0.9, 0.6, 3);
  const std::vector<Vector3d> scene = {middle.p_GI + middle.R_GI * camera.R_CI.transpose() * (ahead_C - camera.p_CI)};
  host::sim::TrackOptions options;
  options.pixel_noise_px = 0;
  options.shortest = 1;
  host::sim::CameraSimulator simulator(camera, 0, truth, scene, effects, options, 0.1, 1);
  std::uint32_t id = 1;
  const auto points = simulator.next_frame(t, id);
  TEST_ASSERT_EQUAL_size_t(1, points.size());
  return Vector2d(points[0].u, points[0].v);
}

/// The frame stamped t of a late camera shows what one that is on time shows at t + t_d.
void time_offset_is_a_shifted_clock() {
  const auto truth = motion();
  const Vector2d late = seen(truth, {host::sim::parse_effect("time_offset=0.013")}, 4);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, (late - seen(truth, {}, 4.013)).norm());
  TEST_ASSERT_TRUE((late - seen(truth, {}, 4)).norm() > 0.5);
}

/// Row v is exposed line_delay (v - h/2) after the stamp: the row where the landmark is found is the row that was used.
void rolling_shutter_exposes_each_row_at_its_time() {
  const auto truth = motion();
  const Vector2d rolled = seen(truth, {host::sim::parse_effect("rolling_shutter=50e-6")}, 4);
  // Three rounds: what is left is 50 us times the change of the row in the second, far below 1e-3 px.
  TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0, (rolled - seen(truth, {}, 4 + 50e-6 * (rolled.y() - 240))).norm());
  TEST_ASSERT_TRUE((rolled - seen(truth, {}, 4)).norm() > 0.05);
}

/// The same where column after column is exposed, of 640.
void rolling_shutter_exposes_each_column_at_its_time() {
  const auto truth = motion();
  const Vector2d rolled = seen(truth, {host::sim::parse_effect("rolling_shutter=50e-6")}, 4, true);
  TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0, (rolled - seen(truth, {}, 4 + 50e-6 * (rolled.x() - 320))).norm());
  TEST_ASSERT_TRUE((rolled - seen(truth, {}, 4)).norm() > 0.05);
}

void lens_terms_act_on_distorted_coordinates() {
  host::CameraCalibration camera;
  camera.intrinsics = {250, 260, 320, 240};
  camera.height = 480;
  Vector2d pixel(445, 110);  // d = (0.5, -0.5)
  host::sim::RadialResidual(0.01).on_pixel(camera, 0, pixel);
  TEST_ASSERT_DOUBLE_WITHIN(1e-10, 320 + 250 * 0.5 * 1.005, pixel.x());
  TEST_ASSERT_DOUBLE_WITHIN(1e-10, 240 - 260 * 0.5 * 1.005, pixel.y());
  pixel = Vector2d(445, 110);
  host::sim::TangentialResidual(0.01, 0.02).on_pixel(camera, 0, pixel);
  TEST_ASSERT_DOUBLE_WITHIN(1e-10, 320 + 250 * (0.5 + 2 * 0.01 * -0.25 + 0.02 * (0.5 + 0.5)), pixel.x());
  TEST_ASSERT_DOUBLE_WITHIN(1e-10, 240 + 260 * (-0.5 + 0.01 * (0.5 + 0.5) + 2 * 0.02 * -0.25), pixel.y());
  TEST_ASSERT_DOUBLE_WITHIN(1e-15, 5, host::sim::RollingShutter(1e-5).exposure_time(camera, 5, 240));
  TEST_ASSERT_DOUBLE_WITHIN(1e-15, 5 + 1e-3, host::sim::RollingShutter(1e-5).exposure_time(camera, 5, 340));
}

/// Three times the noise on the gyroscope alone; the file goes on stating the old one.
void noise_factor_acts_on_its_sensor_alone() {
  const auto plain = simulated(""), noisy = simulated("imu_noise=3,1");
  double gyro_sum = 0, accel_sum = 0;
  const auto& samples = plain.recording.imu.samples;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    gyro_sum += (gyro(noisy.recording.imu.samples[k]) - gyro(samples[k])).squaredNorm() / 3;
    accel_sum += (accel(noisy.recording.imu.samples[k]) - accel(samples[k])).squaredNorm();
  }
  const double stated = plain.recording.imu.noise.gyro_noise_density * std::sqrt(plain.recording.imu.noise.rate_hz);
  // The difference is twice the noise of the plain one; 2400 values: 1.5 % is one sigma.
  TEST_ASSERT_DOUBLE_WITHIN(0.1, 2, std::sqrt(gyro_sum / static_cast<double>(samples.size())) / stated);
  TEST_ASSERT_DOUBLE_WITHIN(0, 0, accel_sum);
  TEST_ASSERT_DOUBLE_WITHIN(0, plain.recording.imu.noise.gyro_noise_density,
                            noisy.recording.imu.noise.gyro_noise_density);
}

void a_shock_leaves_what_was_before() {
  const auto plain = simulated(""), shaken = simulated("calibration_shift=r_CI,2,0.02,0,0");
  const auto &a = plain.recording.cameras[0].frames, &b = shaken.recording.cameras[0].frames;
  for (const auto& p : b[5].points) {
    const auto same =
        std::find_if(a[5].points.begin(), a[5].points.end(), [&](const auto& q) { return q.track_id == p.track_id; });
    TEST_ASSERT_TRUE(same != a[5].points.end());
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, same->u, p.u);
  }
  double farthest = 0;
  for (const auto& p : b[21].points)
    for (const auto& q : a[21].points)
      if (p.track_id == q.track_id) farthest = std::max(farthest, std::abs(p.v - q.v));
  TEST_ASSERT_TRUE(farthest > 2);  // 0.02 rad at f = 256 px
  const auto dull = simulated("calibration_shift=gyro.s,2,0.01,0,0");
  const auto &x = plain.recording.imu.samples, &y = dull.recording.imu.samples;
  TEST_ASSERT_TRUE(gyro(x[100]) == gyro(y[100]));
  TEST_ASSERT_TRUE(gyro(x[700]) != gyro(y[700]));
}

/// At 10 degC above the reference; a point far off the axis moves as the camera turned, zoomed and shifted says.
void camera_temperature_turns_zooms_and_shifts() {
  host::CameraCalibration camera;
  camera.intrinsics = {400, 410, 320, 240};
  const auto effect = host::sim::parse_effect("camera_temperature=0,0,2e-4,3e-4,-1e-4,2e-4");
  const Eigen::Matrix3d before = camera.R_CI;
  effect->on_camera_calibration({5, 0, 35}, camera);
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 400 * 1.003, camera.intrinsics[0]);
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 410 * 1.003, camera.intrinsics[1]);
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 320 - 400 * 1e-3, camera.intrinsics[2]);
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 240 + 410 * 2e-3, camera.intrinsics[3]);
  const Eigen::Matrix3d turn = camera.R_CI * before.transpose();  // about z: x moves towards y
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, std::sin(2e-3), turn(1, 0));
  TEST_ASSERT_TRUE(simulated("camera_temperature=0,0,2e-4,0,0,0", 5).recording.imu.has_temperature);
}

void temperature_is_recorded_when_needed() {
  TEST_ASSERT_FALSE(simulated("").recording.imu.has_temperature);
  const auto warm = simulated("gyro_temperature=1e-4,0,0", 30);
  TEST_ASSERT_TRUE(warm.recording.imu.has_temperature);
  TEST_ASSERT_DOUBLE_WITHIN(0.1, 25, warm.recording.imu.samples.front().temperature_degC);
  TEST_ASSERT_DOUBLE_WITHIN(0.1, 25 + 15 * (1 - std::exp(-3)), warm.recording.imu.samples.back().temperature_degC);
}

bool refused(const std::string& text) {
  try {
    host::sim::parse_effect(text);
  } catch (const host::InputError& error) {
    return std::string(error.what()).find("expected") != std::string::npos;
  }
  return false;
}

void wrong_effects_are_refused() {
  for (const char* text :
       {"", "swim=1", "time_offset", "time_offset=", "time_offset=1,2", "time_offset=a", "gyro_lag=-1",
        "gyro_temperature=1,2", "imu_noise=0", "calibration_shift=q,1,2,3,4", "calibration_shift=r_CI,1,2",
        "dropped_samples=1", "axes=gyro,xxy", "axes=gyro,xy", "frozen=camera,1,1", "time_offset=nan"})
    test::check_true(test::Id().add("text", text), "is refused", refused(text));
}

host::sim::Effects of_model(const std::string& effects) {
  const test::TemporaryFolder folder("simulated_model");
  host::write_file(folder.path() / "model.yaml", "format: 1\n" + effects);
  return host::sim::effects_of_model(folder.path() / "model.yaml");
}

/// What a replay or a diagnosis writes; parameters by name, whatever their order, others zero.
void a_model_file_gives_its_effects() {
  const auto effects = of_model(
      "effects:\n  - name: time_offset\n    parameters:\n"
      "      - {name: \"t_d\", value: 0.003, sigma: 1e-5, unit: \"s\", verdict: observed}\n"
      "  - name: tangential_residual\n    parameters:\n      - {name: \"p2\", value: -0.002}\n");
  TEST_ASSERT_EQUAL_INT(2, static_cast<int>(effects.size()));
  const host::sim::EffectTruth offset = effects[0]->truth(), lens = effects[1]->truth();
  TEST_ASSERT_EQUAL_STRING("time_offset", offset.name.c_str());
  TEST_ASSERT_EQUAL_DOUBLE(0.003, offset.parameters[0].value);
  TEST_ASSERT_EQUAL_STRING("tangential_residual", lens.name.c_str());
  TEST_ASSERT_EQUAL_DOUBLE(0, lens.parameters[0].value);
  TEST_ASSERT_EQUAL_DOUBLE(-0.002, lens.parameters[1].value);
  TEST_ASSERT_TRUE(of_model("effects: []\n").empty());
}

void a_wrong_model_file_is_refused_with_its_line() {
  for (const char* text : {"effects:\n  - name: no_such\n", "effects:\n  - name: term\n",
                           "effects:\n  - {name: time_offset, parameters: [{name: tau, value: 1}]}\n",
                           "effects:\n  - {name: gyro_lag, parameters: [{name: tau, value: -1}]}\n"}) {
    std::string said;
    try {
      of_model(text);
    } catch (const host::InputError& error) {
      said = error.what();
    }
    test::check_true(test::Id().add("text", text), "names file and line",
                     said.find("model.yaml:3") != std::string::npos);
  }
}

}  // namespace

void setUp() {}
void tearDown() {}

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(every_effect_changes_the_recording_and_says_what_it_is);
  RUN_TEST(gyro_lag_is_a_first_order_low_pass);
  RUN_TEST(accel_axis_offset_is_an_accelerometer_elsewhere);
  RUN_TEST(terms_on_the_imu_have_the_stated_size);
  RUN_TEST(time_offset_is_a_shifted_clock);
  RUN_TEST(rolling_shutter_exposes_each_row_at_its_time);
  RUN_TEST(rolling_shutter_exposes_each_column_at_its_time);
  RUN_TEST(lens_terms_act_on_distorted_coordinates);
  RUN_TEST(noise_factor_acts_on_its_sensor_alone);
  RUN_TEST(a_shock_leaves_what_was_before);
  RUN_TEST(camera_temperature_turns_zooms_and_shifts);
  RUN_TEST(temperature_is_recorded_when_needed);
  RUN_TEST(wrong_effects_are_refused);
  RUN_TEST(a_model_file_gives_its_effects);
  RUN_TEST(a_wrong_model_file_is_refused_with_its_line);
  return UNITY_END();
}
