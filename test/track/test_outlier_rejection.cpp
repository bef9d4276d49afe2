// Corners of two images that agree with one epipolar geometry, seen through lenses that nobody has calibrated.
#include <Eigen/Geometry>
#include <random>

#include "../support/cases.h"
#include "track/lens_search.h"
#include "track/outlier_rejection.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kWidth = 640, kHeight = 480, kCorners = 120, kOutliers = 24;
constexpr double kNoise_px = 0.05, kOff_px = 1.5, kMost_px = 1;

/// Where a lens puts what it sees `angle` from its axis, px from the principal point.
struct Lens {
  const char* name;
  double (*radius_px)(double angle);
  double widest_rad;     // of what the corners see
  double bend, bend_to;  // the division model's, near the edge, and how closely it is found
};

const Lens kLenses[] = {
    {"pinhole", [](double a) { return 420 * std::tan(a); }, 0.7, 0, 0.05},
    {"fisheye", [](double a) { return 220 * a; }, 1.75, -1.2, 0.25},  // f theta, to 100 deg off the axis
    {"wide", [](double a) { return 300 * a; }, 1.3, -0.7, 0.25},
};

/// The principal point is 8 px off the image's centre, as no lens is centred.
cv::Point2f seen(const Lens& lens, const Vector3d& p_C) {
  const double angle = std::atan2(p_C.head<2>().norm(), p_C.z());
  const Vector2d px = Vector2d(325, 234) + lens.radius_px(angle) * p_C.head<2>().normalized();
  return {static_cast<float>(px.x()), static_cast<float>(px.y())};
}

struct Scene {
  host::Correspondences corners;
  std::vector<bool> outlier;
};

/// Corners 1 to 6 m away, from a camera that moves by 5 cm and turns by two degrees. The first ones slip across
/// the epipolar line, by kOff_px.
Scene scene(const Lens& lens, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> noise(0, kNoise_px);
  const auto direction = [&] { return Vector3d(uniform(random), uniform(random), uniform(random)).normalized(); };
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.035, direction()).toRotationMatrix();
  const Vector3d p = 0.05 * direction();
  Scene out;
  while (out.outlier.size() < kCorners) {
    const double angle = lens.widest_rad * std::sqrt(std::abs(uniform(random))), around = M_PI * uniform(random);
    const Vector3d ray(std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around), std::cos(angle));
    const double m = 3.5 + 2.5 * uniform(random);
    const cv::Point2f before = seen(lens, m * ray), there = seen(lens, R * (m * ray) + p);
    const cv::Point2f nearer = seen(lens, R * (0.5 * m * ray) + p);  // along the epipolar line
    const auto inside = [](const cv::Point2f& q) {
      return q.x > 8 && q.y > 8 && q.x < kWidth - 8 && q.y < kHeight - 8;
    };
    if (!inside(before) || !inside(there)) continue;
    const cv::Point2f along = nearer - there;
    const bool slips = out.outlier.size() < kOutliers;
    if (slips && cv::norm(along) < 0.2) continue;
    const cv::Point2f across(-along.y, along.x);
    const cv::Point2f slip = slips ? across * (kOff_px / cv::norm(across)) : cv::Point2f();
    const auto wander = [&] {
      return cv::Point2f(static_cast<float>(noise(random)), static_cast<float>(noise(random)));
    };
    out.corners.before.push_back(before + wander());
    out.corners.after.push_back(there + wander() + slip);
    out.outlier.push_back(slips);
  }
  return out;
}

/// Through each lens: nearly all that slip are found, nearly none of the others is called so.
void test_what_slips_is_found() {
  for (const Lens& lens : kLenses) {
    std::vector<host::Correspondences> pairs;
    std::vector<Scene> scenes;
    for (unsigned seed = 1; seed <= 20; ++seed) {
      scenes.push_back(scene(lens, seed));
      pairs.push_back(scenes.back().corners);
    }
    const test::Id id = test::Id().add("lens", lens.name);
    const double bend = host::bend_of(pairs, kWidth, kHeight, kMost_px);
    test::check_near(id, "bend", lens.bend, bend, lens.bend_to);
    const host::DivisionLens division(kWidth, kHeight, bend);
    int missed = 0, lost = 0;
    for (const Scene& s : scenes) {
      const std::vector<bool> inlier = host::epipolar_inliers(division, division, s.corners, kMost_px);
      for (std::size_t i = 0; i < inlier.size(); ++i) {
        missed += s.outlier[i] && inlier[i];
        lost += !s.outlier[i] && !inlier[i];
      }
    }
    std::printf("%s: bend %.1f, %d of %d slips missed, %d of %d others lost\n", lens.name, bend, missed, 20 * kOutliers,
                lost, 20 * (kCorners - kOutliers));
    // 6 % with a pinhole: a slip near the image's edge, or near the epipole, bends the epipolar geometry itself.
    test::check_near(id, "slips missed", 0, missed, 0.1 * 20 * kOutliers);
    // 2.5 sigmas lose 1.2 % of normal errors, and slips make the fit worse.
    test::check_near(id, "others lost", 0, lost, 0.03 * 20 * (kCorners - kOutliers));
  }
}

/// 2.5 robust sigmas, 0.2 px at least, and never more than is allowed.
void test_the_threshold_follows_the_noise() {
  const std::vector<double> exact(100, 0.01), rough(100, 0.1), wild(100, 3);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.2, host::outlier_threshold_px(exact, 1));
  TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.371, host::outlier_threshold_px(rough, 1));  // 2.5 * 1.4826 * 0.1
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1, host::outlier_threshold_px(wild, 1));
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.1, host::outlier_threshold_px(exact, 0.1));
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1, host::outlier_threshold_px({}, 1));
}

/// Seven prove nothing.
void test_few_corners_are_kept() {
  const Scene all = scene(kLenses[0], 1);
  host::Correspondences few;
  few.before.assign(all.corners.before.begin(), all.corners.before.begin() + 7);
  few.after.assign(all.corners.after.begin(), all.corners.after.begin() + 7);
  const host::DivisionLens lens(kWidth, kHeight, 0);
  for (const bool inlier : host::epipolar_inliers(lens, lens, few, kMost_px)) TEST_ASSERT_TRUE(inlier);
  TEST_ASSERT_EQUAL_UINT(0, host::epipolar_inliers(lens, lens, {}, kMost_px).size());
}

/// Against differences.
void test_the_ray_by_the_pixel() {
  const host::DivisionLens lens(kWidth, kHeight, -0.8);
  const Vector2d at(500, 100);
  for (int i = 0; i < 2; ++i) {
    const Vector2d d = 1e-3 * Vector2d::Unit(i);
    const Vector3d slope = (lens.ray(at + d) - lens.ray(at - d)) / 2e-3;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0, (slope - lens.ray_by_pixel(at).col(i)).norm());  // rounding
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_what_slips_is_found);
  RUN_TEST(test_the_threshold_follows_the_noise);
  RUN_TEST(test_few_corners_are_kept);
  RUN_TEST(test_the_ray_by_the_pixel);
  return UNITY_END();
}
