// The simulator's motion and sensors against each other:
// derivatives by differences, samples integrated back to the path.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "simulate/camera_model.h"
#include "simulate/scenarios.h"
#include "simulate/simulate.h"
#include "unity.h"

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Vector3d rotation_vector(const Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

Matrix3d rotation(const Vector3d& v) {
  return v.norm() > 0 ? Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix() : Matrix3d(Matrix3d::Identity());
}

Vector3d vector_of(const std::array<double, 3>& values) { return Vector3d(values[0], values[1], values[2]); }

host::SimulationOptions clean(const std::string& scenario) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = 20;
  options.seed = 3;
  options.device_scale = 0;
  options.with_imu_noise = false;
  options.tracks.pixel_noise_px = 0;
  return options;
}

void spline_weights_sum_to_one_and_keep_straight_lines() {
  for (int degree = 0; degree <= 5; ++degree) {
    const auto basis = host::sim::uniform_basis(degree, 0.37);
    double sum = 0;
    for (double weight : basis) sum += weight;
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 1, sum);
  }
  std::vector<Vector3d> points;
  for (int k = 0; k < 12; ++k) points.emplace_back(0.5 * k, 1, -2.0 * k);
  const host::sim::Spline line(-1, 0.25, points);
  for (double t = line.first_time(); t < line.last_time(); t += 0.07) {
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2 * (t + 1), line.evaluate(t, 0).x());
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -8, line.evaluate(t, 1).z());
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, 0, line.evaluate(t, 2).norm());
  }
}

void rates_and_accelerations_match_central_differences() {
  const double h = 1e-4;
  for (const auto& scenario : host::sim::scenarios()) {
    const auto trajectory = host::sim::make_trajectory(scenario.name, 20, 5);
    for (double t = 0.01; t < 20; t += 0.0517) {
      const auto now = trajectory.at(t), before = trajectory.at(t - h), after = trajectory.at(t + h);
      const Vector3d w = rotation_vector(before.R_GI.transpose() * after.R_GI) / (2 * h);
      TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-6, 0, (w - now.w_GI).norm(), scenario.name);
      const Vector3d v = (after.p_GI - before.p_GI) / (2 * h), a = (after.v_GI - before.v_GI) / (2 * h);
      TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, 0, (v - now.v_GI).norm(), scenario.name);
      TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(5e-6, 0, (a - now.a_GI).norm(), scenario.name);
    }
  }
}

/// Integrates the samples from index `begin` over `n` periods with the trapezoidal rule.
host::sim::BodyState integrated(const host::SimulationResult& result, std::size_t begin, std::size_t n) {
  const auto& samples = result.recording.imu.samples;
  host::sim::BodyState state = result.state_at(samples[begin].t_ns).body;
  for (std::size_t k = begin; k < begin + n; ++k) {
    const double dt = static_cast<double>(samples[k + 1].t_ns - samples[k].t_ns) * 1e-9;
    const Vector3d w0 = vector_of(samples[k].gyro), w1 = vector_of(samples[k + 1].gyro);
    const Matrix3d R1 = state.R_GI * rotation(0.5 * dt * (w0 + w1) + dt * dt / 12 * w0.cross(w1));
    const Vector3d a0 = state.R_GI * vector_of(samples[k].accel) + host::sim::gravity_G;
    const Vector3d a1 = R1 * vector_of(samples[k + 1].accel) + host::sim::gravity_G;
    state.p_GI += dt * state.v_GI + dt * dt * (a0 / 3 + a1 / 6);
    state.v_GI += dt / 2 * (a0 + a1);
    state.R_GI = R1;
  }
  return state;
}

void samples_without_noise_integrate_to_the_path() {
  const std::size_t one_second = 200;
  for (const auto& scenario : host::sim::scenarios()) {
    const auto result = host::simulate(clean(scenario.name));
    const auto& samples = result.recording.imu.samples;
    for (std::size_t begin = 0; begin + one_second < samples.size(); begin += one_second) {
      const auto end = integrated(result, begin, one_second);
      const auto truth = result.state_at(samples[begin + one_second].t_ns).body;
      // A quarter of what the sensors' own noise does in one second, or less.
      TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-4, 0, rotation_vector(end.R_GI.transpose() * truth.R_GI).norm(),
                                        scenario.name);
      TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-3, 0, (end.v_GI - truth.v_GI).norm(), scenario.name);
      TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(7e-4, 0, (end.p_GI - truth.p_GI).norm(), scenario.name);
    }
  }
}

void device_errors_enter_the_samples_as_stated() {
  host::SimulationOptions options = clean("rich");
  options.device_scale = 1;
  const auto result = host::simulate(options);
  const auto& imu = result.truth.imu;
  TEST_ASSERT_TRUE((imu.T_g - Matrix3d::Identity()).norm() > 1e-4);
  for (std::size_t k = 0; k < result.recording.imu.samples.size(); k += 97) {
    const auto& sample = result.recording.imu.samples[k];
    const auto body = result.state_at(sample.t_ns).body;
    const Vector3d f_I = body.R_GI.transpose() * (body.a_GI - Vector3d(0, 0, -9.80665));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, (vector_of(sample.gyro) - imu.T_g * body.w_GI).norm());
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, (vector_of(sample.accel) - imu.T_a * imu.R_AI * f_I).norm());
  }
}

void lens_models_meet_at_the_axis_and_refuse_what_they_cannot_see() {
  host::CameraCalibration camera;
  camera.width = 640;
  camera.height = 480;
  camera.intrinsics = {256, 250, 320, 240};
  for (auto model : {host::DistortionModel::fov, host::DistortionModel::radtan, host::DistortionModel::equidistant}) {
    camera.model = model;
    camera.distortion = Eigen::Vector4d(model == host::DistortionModel::fov ? 0.92 : 0.01, 0, 0, 0);
    const auto centre = host::sim::project(camera, {0, 0, 2}, 0);
    TEST_ASSERT_TRUE(centre.has_value());
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 320, centre->x());
    // Both sides of the switch to the limit at the axis have the slope f times the lens's gain there.
    const double slope = model == host::DistortionModel::fov ? 256 * 2 * std::tan(0.46) / 0.92 : 256;
    for (double x : {1e-10, 1e-8, 1e-6}) {
      const auto beside = host::sim::project(camera, {2 * x, 0, 2}, 0);
      TEST_ASSERT_DOUBLE_WITHIN(2e-13 + 1e-9 * slope * x, slope * x, beside->x() - 320);
    }
    TEST_ASSERT_FALSE(host::sim::project(camera, {0, 0, -1}, 0).has_value());
    TEST_ASSERT_FALSE(host::sim::project(camera, {20, 0, 1}, 0).has_value());
  }
}

}  // namespace

void setUp() {}
void tearDown() {}

int main() {
  UNITY_BEGIN();
  RUN_TEST(spline_weights_sum_to_one_and_keep_straight_lines);
  RUN_TEST(rates_and_accelerations_match_central_differences);
  RUN_TEST(samples_without_noise_integrate_to_the_path);
  RUN_TEST(device_errors_enter_the_samples_as_stated);
  RUN_TEST(lens_models_meet_at_the_axis_and_refuse_what_they_cannot_see);
  return UNITY_END();
}
