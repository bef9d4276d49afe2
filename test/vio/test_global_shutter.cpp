// A point that a rolling shutter exposed later, turned back to the stamp of its frame.
#include <unity.h>

#include <cmath>

#include "../support/cases.h"
#include "vio/global_shutter.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace SEGCAL_NS;
using test::Id;

constexpr std::int64_t kStamp = 500000000;  // ns, in the middle of a second of samples

/// rad/s, turning ever faster about a fixed axis, so that attitudes are known in closed form; t in s from the stamp.
const Vec3<double> kAxis = Vec3<double>(0.3, -0.8, 0.5).normalized();
double angle(double t) { return 3 * t + 10 * t * t; }

ImuHistory<double> turning(const Vec3<double>& b_g) {
  ImuHistory<double> imu;
  for (int i = 0; i <= 200; ++i) {
    const double t = i * 0.005 - 1e-9 * double(kStamp);
    imu.push(std::int64_t(i) * 5000000, {Vec3<double>(kAxis * (3 + 20 * t) + b_g), Vec3<double>(0, 0, 9.8)});
  }
  return imu;
}

CameraCalibration<double> camera_of(Distortion model) {
  CameraCalibration<double> camera;
  camera.model = model;
  camera.intrinsics = Vec<double, 4>(450, 455, 318, 242);
  camera.distortion = model == Distortion::fov ? Vec<double, 4>(0.9, 0, 0, 0) : Vec<double, 4>(-0.28, 0.07, 1e-3, 2e-4);
  camera.R_CI = so3_exp<double>(Vec3<double>(1.2, -1.1, 1.3));
  return camera;
}

/// 70 us per row, 4 rad/s: points move by up to 30 px. What is left is the rate's curvature, none here, and the
/// Newton steps of the lens.
void test_points_return_to_the_stamp() {
  const Vec3<double> b_g(0.02, -0.05, 0.03);
  const ImuHistory<double> imu = turning(b_g);
  for (const Distortion model : {Distortion::fov, Distortion::radtan}) {
    const CameraCalibration<double> camera = camera_of(model);
    const RateAbout<double> rate(imu, kStamp, ImuCalibration<double>(), b_g);
    double moved = 0;
    for (const double y : {-0.45, 0.0, 0.4}) {
      const Vec3<double> far_G(0.2, y, 1);  // a direction in the axes of C at the stamp
      Vec2<double> at_stamp, uv;
      TEST_ASSERT_TRUE(project(camera, far_G, &at_stamp));
      uv = at_stamp;
      for (int i = 0; i < 40; ++i) {  // the row decides when it is exposed, and that decides the row
        const double tau = 70e-6 * camera.line_of(uv.x(), uv.y());
        const Mat3<double> turn = so3_exp<double>(Vec3<double>(angle(tau) * kAxis));
        TEST_ASSERT_TRUE(
            project(camera, Vec3<double>(camera.R_CI * (turn.transpose() * (camera.R_CI.transpose() * far_G))), &uv));
      }
      moved = std::max(moved, (uv - at_stamp).norm());
      turn_to_stamp(camera, 70e-6, rate, &uv);
      test::check_near(Id().add("lens", int(model)).add("y", y), "px", 0, (uv - at_stamp).norm(), 1e-3);
    }
    TEST_ASSERT_TRUE(moved > 15);  // else there was nothing to undo
  }
}

void test_no_delay_moves_nothing() {
  const RateAbout<double> rate(turning(Vec3<double>::Zero()), kStamp, ImuCalibration<double>(), Vec3<double>::Zero());
  Vec2<double> uv(100, 400);
  turn_to_stamp(camera_of(Distortion::radtan), 0.0, rate, &uv);
  test::check_near(Id(), "px", 0, (uv - Vec2<double>(100, 400)).norm(), 1e-8);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_points_return_to_the_stamp);
  RUN_TEST(test_no_delay_moves_nothing);
  return UNITY_END();
}
