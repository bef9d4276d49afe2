// Structure in residuals: white noise has none, a dependence on
// a cause is found and named, slow noise is not taken for one.
#include <cmath>
#include <vector>

#include "../support/cases.h"
#include "../support/random.h"
#include "diagnose/structure.h"

using namespace host::diagnosis;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr int kCount = 2000;
constexpr double kLevel = -3;

/// Noise of unit variance with neighbours alike by `alike`, held against slow sines of rate and force and against time.
ResidualList noise_list(test::Random* random, double alike) {
  ResidualList list{"gyro", "x", {}, {}, {}};
  double slow = 0;
  for (int i = 0; i < kCount; ++i) {
    slow = alike * slow + std::sqrt(1 - alike * alike) * random->normal();
    list.value.push_back(slow);
    list.series.push_back(i / 100);
    list.cause[static_cast<int>(Cause::time)].push_back(0.03 * i);
    list.cause[static_cast<int>(Cause::rate_y)].push_back(std::sin(0.05 * i) + random->normal(0.1));
    list.cause[static_cast<int>(Cause::force_z)].push_back(9.8 + std::cos(0.07 * i) + random->normal(0.1));
  }
  return list;
}

void test_noise_has_no_structure() {
  int white = 0, slow = 0;
  for (int seed = 0; seed < 100; ++seed) {
    test::Random random(seed);
    white += find_structure({noise_list(&random, 0)}, kLevel, 3).empty() ? 0 : 1;
    slow += find_structure({noise_list(&random, 0.6)}, kLevel, 3).empty() ? 0 : 1;
  }
  TEST_ASSERT_LESS_OR_EQUAL_INT(2, white);  // 0.1 expected
  TEST_ASSERT_LESS_OR_EQUAL_INT(3, slow);
}

/// Forty points see each of fifty images, whose stamps err: what the points of an image have in common is one error,
/// not forty. Counted as forty, images that turned quickly and had bad stamps by chance make structure in each of a
/// hundred recordings.
void test_points_of_an_image_share_its_error() {
  int found = 0;
  for (int seed = 0; seed < 100; ++seed) {
    test::Random random(500 + seed);
    double error[50], rate[50];
    for (int image = 0; image < 50; ++image) {
      error[image] = random.normal(0.7);
      rate[image] = random.normal();
    }
    ResidualList list{"camera", "v", {}, {}, {}};
    for (int i = 0; i < kCount; ++i) {
      list.value.push_back(error[i % 50] + random.normal(0.7));
      list.series.push_back(i / 50);
      list.cause[static_cast<int>(Cause::time)].push_back(0.1 * (i % 50));
      list.cause[static_cast<int>(Cause::rate_y)].push_back(rate[i % 50]);
    }
    found += find_structure({list}, kLevel, 3).empty() ? 0 : 1;
  }
  // 0.1 expected, and more: sixteen pieces tell their scatter to a third.
  TEST_ASSERT_LESS_OR_EQUAL_INT(6, found);
}

/// A quarter of a sigma over the range of the cause, straight or bent.
void test_dependence_is_named() {
  for (const bool bent : {false, true}) {
    for (int seed = 0; seed < 20; ++seed) {
      test::Random random(200 + seed);
      ResidualList list = noise_list(&random, 0);
      for (int i = 0; i < kCount; ++i) {
        const double rate = list.cause[static_cast<int>(Cause::rate_y)][i];
        list.value[i] += bent ? 0.6 * rate * rate : 0.25 * rate;
      }
      const std::vector<Structure> found = find_structure({list}, kLevel, 3);
      TEST_ASSERT_FALSE(found.empty());
      TEST_ASSERT_EQUAL_STRING("rate y", found.front().against.c_str());
      TEST_ASSERT_TRUE(std::abs(found.front().correlation) > 0.1);
    }
  }
}

/// A segment of a camera that turns slowly, so that corners move by less than their noise from image to image: points
/// fitted by straight lines along each track, as landmarks and poses are, and what that leaves.
host::CoreKept slow_tracks(test::Random* random, double pixel_sigma, double follows_motion_s) {
  constexpr int kImages = 16, kTracks = 60;
  constexpr double kPeriod = 0.1;
  host::CoreKept out;
  out.keyframes.resize(kImages);
  for (int k = 0; k < kImages; ++k) out.keyframes[k].t_ns = static_cast<std::int64_t>(1e9 * kPeriod * k);
  for (int landmark = 0; landmark < kTracks; ++landmark) {
    double noise[2][kImages], mean[2] = {0, 0}, slope[2] = {0, 0};
    const double start[2] = {320 + random->normal(120), 240 + random->normal(90)},
                 rate[2] = {random->normal(6), random->normal(6)};
    double spread = 0;
    for (int k = 0; k < kImages; ++k) spread += (k - 7.5) * (k - 7.5);
    for (int axis = 0; axis < 2; ++axis) {
      for (int k = 0; k < kImages; ++k) {
        noise[axis][k] = pixel_sigma * random->normal();
        mean[axis] += noise[axis][k] / kImages;
        slope[axis] += noise[axis][k] * (k - 7.5) / spread;
      }
    }
    for (int k = 0; k < kImages; ++k) {
      double measured[2], residual[2];
      for (int axis = 0; axis < 2; ++axis) {
        measured[axis] = start[axis] + rate[axis] * kPeriod * k + noise[axis][k];
        residual[axis] =
            (mean[axis] + slope[axis] * (k - 7.5) - noise[axis][k] + follows_motion_s * rate[axis]) / pixel_sigma;
      }
      host::CorePoint point;
      point.landmark = landmark;
      point.keyframe = k;
      point.u = measured[0];
      point.v = measured[1];
      out.measured.push_back(point);
      out.points.push_back({out.keyframes[k].t_ns, 0, residual[0], residual[1]});
    }
  }
  return out;
}

/// How many of `sessions` sessions of eight slow segments have residuals that follow the image's motion.
int follow_image_motion(int sessions, double follows_motion_s) {
  host::CoreModel model;
  model.pixel_sigma = 0.5;
  host::Calibration calibration;
  calibration.cameras.resize(1);
  int found = 0;
  for (int seed = 0; seed < sessions; ++seed) {
    test::Random random(400 + seed);
    std::vector<host::CoreKept> kept;
    for (int i = 0; i < 8; ++i) kept.push_back(slow_tracks(&random, model.pixel_sigma, follows_motion_s));
    bool follows = false;
    for (const Structure& s : find_structure(residual_lists(kept, model, calibration, {}), kLevel, kCauses)) {
      follows = follows || s.against.rfind("image motion", 0) == 0;
    }
    found += follows ? 1 : 0;
  }
  return found;
}

/// A motion that is read from the very points that are tested
/// holds their noise: each slow, clean recording would follow it.
void test_slow_images_do_not_follow_their_own_noise() {
  TEST_ASSERT_LESS_OR_EQUAL_INT(1, follow_image_motion(30, 0));  // 0.03 expected
  TEST_ASSERT_EQUAL_INT(30, follow_image_motion(30, 0.01));      // 10 ms at 6 px/s: 0.06 px, 0.12 sigma, of 7680 points
}

void test_autocorrelation() {
  test::Random random(7);
  // Standard error of a correlation of 2000 numbers: 0.022.
  TEST_ASSERT_DOUBLE_WITHIN(0.09, 0, lag_one_autocorrelation(noise_list(&random, 0)));
  TEST_ASSERT_DOUBLE_WITHIN(0.09, 0.6, lag_one_autocorrelation(noise_list(&random, 0.6)));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_noise_has_no_structure);
  RUN_TEST(test_points_of_an_image_share_its_error);
  RUN_TEST(test_dependence_is_named);
  RUN_TEST(test_slow_images_do_not_follow_their_own_noise);
  RUN_TEST(test_autocorrelation);
  return UNITY_END();
}
