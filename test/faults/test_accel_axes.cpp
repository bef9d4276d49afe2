// Whether another order of the accelerometer's axes keeps gravity better, apart from a gyroscope's bias that is known
// badly.
#include <unity.h>

#include "diagnose/accel_axes.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// A minute that turns to and fro about one axis, with gravity across it, and a gyroscope with a bias, rad/s.
host::Recording recording(const Eigen::Vector3d& axis, double turned_rad, const Eigen::Vector3d& bias) {
  host::Recording out;
  for (int k = 0; k < 12000; ++k) {
    const double t = k * 0.005, angle = turned_rad * std::sin(t);
    const Eigen::Vector3d rate = axis * turned_rad * std::cos(t) + bias;
    const Eigen::Matrix3d R = host::rotation_of(Eigen::Vector3d(axis * angle));
    const Eigen::Vector3d force = R.transpose() * Eigen::Vector3d(9.6, 0.5, 1.9);
    host::ImuSample s;
    s.t_ns = static_cast<std::int64_t>(k) * 5000000;
    for (int i = 0; i < 3; ++i) {
      s.gyro[static_cast<std::size_t>(i)] = rate[i];
      s.accel[static_cast<std::size_t>(i)] = force[i];
    }
    out.imu.samples.push_back(s);
  }
  return out;
}

std::vector<host::Fault> faults(const host::Recording& r) {
  std::vector<host::Fault> out;
  host::accel_axes_fault(r, host::GyroPath(r), Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity(), &out);
  return out;
}

/// 0.09 rad/s turn gravity by 0.7 rad in a window: as it is 2 % of it are lost, and with gravity along the axis of the
/// bias none.
void test_a_bias_is_no_wrong_order() {
  TEST_ASSERT_TRUE(faults(recording({0, 0, 1}, 0.3, {0, 0, 0.09})).empty());
  TEST_ASSERT_TRUE(faults(recording({0, 0, 1}, 0, {0, 0.05, 0.08})).empty());
}

void test_a_wrong_order_is_found_beside_a_bias() {
  host::Recording r = recording({0, 0.6, 0.8}, 0.5, {0, 0, 0.05});
  TEST_ASSERT_TRUE(faults(r).empty());
  for (host::ImuSample& s : r.imu.samples) s.accel = {s.accel[1], s.accel[2], s.accel[0]};
  const std::vector<host::Fault> found = faults(r);
  TEST_ASSERT_EQUAL_size_t(1, found.size());
  TEST_ASSERT_EQUAL_STRING("accel", found[0].sensor.c_str());
  TEST_ASSERT_TRUE(found[0].words.find("read as z x y") != std::string::npos);
}

/// Values that are not numbers are no force, and the search ends; neither where there is hardly anything else.
void test_what_is_not_a_number_ends() {
  host::Recording r = recording({0, 0, 1}, 0.3, {0, 0, 0.09});
  for (std::size_t k = 0; k < r.imu.samples.size(); k += 500) r.imu.samples[k].accel[0] = std::nan("");
  TEST_ASSERT_TRUE(faults(r).empty());
  for (host::ImuSample& s : r.imu.samples) s.accel[1] = std::nan("");
  TEST_ASSERT_TRUE(faults(r).empty());
  r = recording({0, 0, 1}, 0.3, {0, 0, 0.09});
  r.imu.noise.rate_hz = 2;  // as somebody stated it: windows of one block
  TEST_ASSERT_TRUE(faults(r).empty());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_bias_is_no_wrong_order);
  RUN_TEST(test_what_is_not_a_number_ends);
  RUN_TEST(test_a_wrong_order_is_found_beside_a_bias);
  return UNITY_END();
}
