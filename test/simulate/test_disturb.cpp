// Disturbances of a finished recording do what they say, to what they name, and to nothing else.
#include <cmath>

#include "../support/cases.h"
#include "simulate/disturb.h"
#include "simulate/simulate.h"
#include "unity.h"

using host::disturb::Sensor;

namespace {

host::Recording recording() {
  static const host::Recording made = [] {
    host::SimulationOptions options;
    options.seconds = 10;
    options.seed = 2;
    return host::simulate(options).recording;
  }();
  return made;
}

void clip_limits_values_and_leaves_the_rest() {
  const auto before = recording();
  auto after = before;
  host::disturb::clip(after, 1.5, 0);
  std::size_t clipped = 0;
  for (std::size_t k = 0; k < before.imu.samples.size(); ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double was = before.imu.samples[k].gyro[i], is = after.imu.samples[k].gyro[i];
      TEST_ASSERT_DOUBLE_WITHIN(0, std::abs(was) <= 1.5 ? was : std::copysign(1.5, was), is);
      clipped += std::abs(was) > 1.5 ? 1 : 0;
      TEST_ASSERT_DOUBLE_WITHIN(0, before.imu.samples[k].accel[i], after.imu.samples[k].accel[i]);
    }
  }
  TEST_ASSERT_TRUE(clipped > 10);
}

void every_nth_sample_is_dropped() {
  const auto before = recording();
  auto after = before;
  host::disturb::drop_imu_samples(after, 50);
  TEST_ASSERT_EQUAL_size_t(before.imu.samples.size() - before.imu.samples.size() / 50, after.imu.samples.size());
  TEST_ASSERT_EQUAL_INT64(before.imu.samples[48].t_ns, after.imu.samples[48].t_ns);
  TEST_ASSERT_EQUAL_INT64(before.imu.samples[50].t_ns, after.imu.samples[49].t_ns);
}

void jitter_has_the_stated_size_and_keeps_the_order() {
  const auto before = recording();
  auto after = before;
  host::disturb::jitter_stamps(after, 5e-4, 2e-3, 7);
  double squares = 0;
  for (std::size_t k = 0; k < before.imu.samples.size(); ++k) {
    const double off = static_cast<double>(after.imu.samples[k].t_ns - before.imu.samples[k].t_ns) * 1e-9;
    squares += off * off;
    if (k > 0) TEST_ASSERT_TRUE(after.imu.samples[k].t_ns > after.imu.samples[k - 1].t_ns);
    TEST_ASSERT_DOUBLE_WITHIN(0, before.imu.samples[k].gyro[0], after.imu.samples[k].gyro[0]);
  }
  // 2000 samples: 1.6 % is one sigma of the deviation.
  TEST_ASSERT_DOUBLE_WITHIN(0.07 * 5e-4, 5e-4, std::sqrt(squares / static_cast<double>(before.imu.samples.size())));
  TEST_ASSERT_TRUE(after.cameras[0].frames[5].t_ns != before.cameras[0].frames[5].t_ns);
}

void freeze_repeats_one_reading() {
  auto after = recording();
  const auto before = after;
  host::disturb::freeze(after, Sensor::accel, before.imu.samples[400].t_ns, 0.5);
  for (std::size_t k = 400; k < 500; ++k) TEST_ASSERT_TRUE(after.imu.samples[k].accel == before.imu.samples[400].accel);
  TEST_ASSERT_TRUE(after.imu.samples[500].accel == before.imu.samples[500].accel);
  TEST_ASSERT_TRUE(after.imu.samples[450].gyro == before.imu.samples[450].gyro);
}

void scale_begins_at_its_time() {
  auto after = recording();
  const auto before = after;
  const std::int64_t middle = host::disturb::middle_ns(before);
  host::disturb::scale(after, Sensor::gyro, {1, 1, 1.01}, middle);
  for (std::size_t k = 0; k < before.imu.samples.size(); k += 37) {
    const auto &a = before.imu.samples[k], &b = after.imu.samples[k];
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, a.gyro[2] * (a.t_ns >= middle ? 1.01 : 1), b.gyro[2]);
    TEST_ASSERT_DOUBLE_WITHIN(0, a.gyro[0], b.gyro[0]);
  }
}

void axes_are_reordered_as_written() {
  auto after = recording();
  const auto before = after;
  host::disturb::reorder_axes(after, Sensor::gyro, "z-xy");
  const auto &a = before.imu.samples[11].gyro, &b = after.imu.samples[11].gyro;
  TEST_ASSERT_DOUBLE_WITHIN(0, a[2], b[0]);
  TEST_ASSERT_DOUBLE_WITHIN(0, -a[0], b[1]);
  TEST_ASSERT_DOUBLE_WITHIN(0, a[1], b[2]);
}

void camera_stamps_shift_and_drift() {
  auto after = recording();
  const auto before = after;
  host::disturb::shift_camera_stamps(after, 3e-3, 1e-4);
  const auto &a = before.cameras[0].frames, &b = after.cameras[0].frames;
  TEST_ASSERT_EQUAL_INT64(a[0].t_ns + 3000000, b[0].t_ns);
  TEST_ASSERT_INT64_WITHIN(1, a[50].t_ns + 3000000 + 500000, b[50].t_ns);  // 5 s later
  TEST_ASSERT_EQUAL_INT64(before.imu.samples[9].t_ns, after.imu.samples[9].t_ns);
}

void g_sensitivity_adds_the_specific_force() {
  auto after = recording();
  const auto before = after;
  Eigen::Matrix3d T_gs = Eigen::Matrix3d::Zero();
  T_gs(0, 2) = 1e-3;
  host::disturb::add_g_sensitivity(after, T_gs);
  for (std::size_t k = 0; k < before.imu.samples.size(); k += 91) {
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, before.imu.samples[k].gyro[0] + 1e-3 * before.imu.samples[k].accel[2],
                              after.imu.samples[k].gyro[0]);
    TEST_ASSERT_DOUBLE_WITHIN(0, before.imu.samples[k].gyro[1], after.imu.samples[k].gyro[1]);
  }
}

}  // namespace

void setUp() {}
void tearDown() {}

int main() {
  UNITY_BEGIN();
  RUN_TEST(clip_limits_values_and_leaves_the_rest);
  RUN_TEST(every_nth_sample_is_dropped);
  RUN_TEST(jitter_has_the_stated_size_and_keeps_the_order);
  RUN_TEST(freeze_repeats_one_reading);
  RUN_TEST(scale_begins_at_its_time);
  RUN_TEST(axes_are_reordered_as_written);
  RUN_TEST(camera_stamps_shift_and_drift);
  RUN_TEST(g_sensitivity_adds_the_specific_force);
  return UNITY_END();
}
