// A filter that is given a calibration while it runs: motion and biases go where its information puts them for that.
#include <unity.h>

#include <Eigen/LU>
#include <algorithm>
#include <memory>
#include <vector>

#include "../support/cases.h"
#include "../support/random.h"
#include "vio/sensor_priors.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

Calibration<double> device(int terms) {
  Calibration<double> theta;
  theta.camera[0].model = Distortion::radtan;
  theta.camera[0].intrinsics << 400, 410, 320, 240;
  for (int i = 0; i < terms; ++i) {
    Term term{};
    theta.effects.add(term, 0);
  }
  return theta;
}

/// A window of two poses with information of any kind about everything.
std::unique_ptr<Window<double>> window(const Calibration<double>& theta, test::Random* random) {
  auto w = std::make_unique<Window<double>>();
  w->reset(theta);
  w->append_empty(1);
  w->append_empty(2);
  for (int i = 0; i < w->n_poses; ++i) {
    w->pose[i].R_GI = Mat3<double>::Identity();
    w->pose[i].p_GI = Vec3<double>::Zero();
  }
  const int n = w->columns();
  PackedTriangle<double> R = w->R();
  R.clear();
  for (int j = 0; j < n; ++j) {
    const bool used = j < pose_column(2) || j >= camera_column(0);  // poses that are not there have no information
    for (int c = j; used && c < n; ++c) {
      if (c < pose_column(2) || c >= camera_column(0))
        R.row(j)[c] = c == j ? random->uniform(1, 2) : random->normal(0.3);
    }
  }
  return w;
}

/// With R the window's rows of all else [A B], A dx + B delta = 0 is where delta puts the mean of x.
void check(int terms) {
  const Id id = Id().add("terms", terms);
  test::Random random(7);
  const Calibration<double> before = device(terms);
  auto w = window(before, &random);
  Calibration<double> after = before;
  Eigen::VectorXd delta(before.columns());
  for (int i = 0; i < delta.size(); ++i) delta(i) = random.normal(1e-3);
  add_step(&after, delta.data());

  const int x = pose_column(2), first = camera_column(0), n = w->columns();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(x, x), B = Eigen::MatrixXd::Zero(x, n - first);
  for (int j = 0; j < x; ++j) {
    for (int c = j; c < x; ++c) A(j, c) = w->R()(j, c);
    for (int c = first; c < n; ++c) B(j, c - first) = w->R()(j, c);
  }
  const Eigen::VectorXd step = A.lu().solve(-B * delta.head(n - first));
  const std::vector<double> known(w->triangle, w->triangle + packed_size(n + 1));
  take_calibration(after, w.get());

  for (int i = 0; i < 3; ++i) {
    test::check_near(id.add("axis", i), "velocity", step(i), w->now.v_GI(i), 1e-12);
    test::check_near(id.add("axis", i), "accelerometer bias", step(3 + i), w->now.b_a(i), 1e-12);
    test::check_near(id.add("axis", i), "gyroscope bias", step(6 + i), w->now.b_g(i), 1e-12);
    for (int k = 0; k < 2; ++k) {
      test::check_near(id.add("pose", k).add("axis", i), "place", step(pose_column(k) + 3 + i), w->pose[k].p_GI(i),
                       1e-12);
    }
  }
  // The calibration is the given one, to the bit, and known as well as before.
  TEST_ASSERT_TRUE(w->theta.camera[0].R_CI == after.camera[0].R_CI &&
                   w->theta.imu.accel_scale == after.imu.accel_scale);
  for (int j = 0; j < n; ++j) TEST_ASSERT_TRUE(w->R()(j, n) == 0);
  TEST_ASSERT_TRUE(std::equal(known.begin(), known.end(), w->triangle));
}

void test_motion_and_biases_follow() { check(0); }
/// Effects stand behind the sensors, in the calibration but not in the filter.
void test_as_many_effects_as_there_may_be() { check(kMaxEffectEstimates); }

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_motion_and_biases_follow);
  RUN_TEST(test_as_many_effects_as_there_may_be);
  return UNITY_END();
}
