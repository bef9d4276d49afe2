// Effects that move to and fro, at their hooks: period, size, and a mean of zero.
#include <Eigen/Geometry>
#include <cmath>

#include "angles.h"
#include "simulate/effect_names.h"
#include "simulate/effects_wandering.h"
#include "simulate/simulate.h"
#include "unity.h"

namespace {

constexpr double rounding = 1e-12;  // a few operations in double on numbers of order 1 to 500

host::CameraCalibration camera() {
  host::CameraCalibration out;
  out.width = 640;
  out.height = 480;
  out.intrinsics = {256, 258, 319.5, 239.5};
  return out;
}

void focus_hunts_about_the_calibrated_one() {
  const host::sim::FocusHunting hunting(0.002);
  const auto factor = [&](double t) {
    host::CameraCalibration moved = camera();
    hunting.on_camera_calibration({t, 0}, moved);
    TEST_ASSERT_EQUAL_DOUBLE(319.5, moved.intrinsics[2]);
    TEST_ASSERT_DOUBLE_WITHIN(rounding, moved.intrinsics[0] / 256, moved.intrinsics[1] / 258);
    return moved.intrinsics[0] / 256;
  };
  TEST_ASSERT_DOUBLE_WITHIN(rounding, 1, factor(0));
  TEST_ASSERT_DOUBLE_WITHIN(rounding, 1.002, factor(7 * 0.25));
  TEST_ASSERT_DOUBLE_WITHIN(rounding, 0.998, factor(7 * 0.75));
}

/// The stated angle to one side or the other, the same for 1.7 s; both sides come about equally often.
void a_loose_mount_has_two_places() {
  const host::sim::LooseMount mount(0.003);
  int positive = 0;
  for (int k = 0; k < 200; ++k) {
    double sides[2];
    for (int i = 0; i < 2; ++i) {
      host::CameraCalibration moved = camera();
      mount.on_camera_calibration({1.7 * (k + 0.1 + 0.8 * i), 0}, moved);
      const Eigen::AngleAxisd turned(moved.R_CI);
      TEST_ASSERT_DOUBLE_WITHIN(
          1e-9, 0.003, turned.angle());  // an angle of 3e-3 out of a matrix: its square root of rounding at worst
      sides[i] = turned.axis().y();
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, sides[0], sides[1]);
    positive += sides[0] > 0;
  }
  TEST_ASSERT_INT_WITHIN(28, 100, positive);  // four standard deviations of 200 fair draws
}

void stamps_wander_and_are_right_on_average() {
  const host::sim::WanderingStamps stamps(1e-3);
  double sum = 0;
  for (int k = 0; k < 110; ++k) sum += stamps.exposure_time(camera(), 0.1 * k, 0) - 0.1 * k;
  TEST_ASSERT_DOUBLE_WITHIN(rounding, 0, sum / 110);  // a whole period
  TEST_ASSERT_DOUBLE_WITHIN(rounding, 1e-3, stamps.exposure_time(camera(), 11 * 0.25, 0) - 11 * 0.25);
}

void a_two_way_shutter_is_right_on_average_over_its_rows() {
  const host::sim::TwoWayShutter shutter(5e-6);
  double sum = 0;
  for (int v = 0; v < 480; ++v) sum += shutter.exposure_time(camera(), 0, v + 0.5);
  TEST_ASSERT_DOUBLE_WITHIN(rounding, 0, sum / 480);
  TEST_ASSERT_DOUBLE_WITHIN(rounding, -6e-4, shutter.exposure_time(camera(), 0, 240));
  TEST_ASSERT_DOUBLE_WITHIN(rounding, 6e-4, shutter.exposure_time(camera(), 0, 0));
  TEST_ASSERT_DOUBLE_WITHIN(rounding, 6e-4, shutter.exposure_time(camera(), 0, 480));
}

/// Of a recording with and without it: k / sqrt(2) on each axis, and the accelerometer as it was.
void a_hum_is_on_the_gyroscope_alone() {
  host::SimulationOptions options;
  options.seconds = 10;  // thirteen periods
  options.seed = 3;
  const host::SimulationResult without = host::simulate(options);
  options.effects.push_back(host::sim::parse_effect("outside:gyro_hum=0.005"));
  const host::SimulationResult with = host::simulate(options);
  const std::size_t n = with.recording.imu.samples.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double squares = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const auto &a = with.recording.imu.samples[k], &b = without.recording.imu.samples[k];
      squares += std::pow(a.gyro[axis] - b.gyro[axis], 2);
      TEST_ASSERT_TRUE(a.accel[axis] == b.accel[axis]);
    }
    TEST_ASSERT_DOUBLE_WITHIN(
        0.01 * 0.005, 0.005 / std::sqrt(2.0),
        std::sqrt(squares / static_cast<double>(n)));  // samples reach a little beyond whole periods
  }
}

}  // namespace

void setUp() {}
void tearDown() {}

int main() {
  UNITY_BEGIN();
  RUN_TEST(focus_hunts_about_the_calibrated_one);
  RUN_TEST(a_loose_mount_has_two_places);
  RUN_TEST(stamps_wander_and_are_right_on_average);
  RUN_TEST(a_two_way_shutter_is_right_on_average_over_its_rows);
  RUN_TEST(a_hum_is_on_the_gyroscope_alone);
  return UNITY_END();
}
