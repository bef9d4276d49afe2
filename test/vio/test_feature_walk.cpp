// Rows of a feature whose corner walks: R^T R of them is J^T C^-1 J, with C = sigma^2 I + q^2 (min(t_i, t_j) - t_0).
#include <unity.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <memory>

#include "../support/cases.h"
#include "../support/random.h"
#include "vio/vio_update.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr int kPoses = 7;
constexpr double kSigma = 0.8;  // px

/// A window of poses at uneven times that look at one landmark, and its track, which misses one of them.
struct Scene {
  std::unique_ptr<Window<double>> w = std::make_unique<Window<double>>();
  VioTrack<double> track{};
  Landmark<double> landmark;

  explicit Scene(std::uint64_t seed) {
    test::Random random(seed);
    Calibration<double> theta;
    theta.camera[0].model = Distortion::radtan;
    theta.camera[0].intrinsics << 400, 410, 320, 240;
    w->reset(theta);
    std::int64_t t_ns = 1'000'000'000;
    for (int i = 0; i < kPoses; ++i) {
      const int slot = w->append_empty(t_ns += static_cast<std::int64_t>(random.uniform(0.05e9, 0.4e9)));
      WindowPose<double>& pose = w->pose[i];
      pose.R_GI = pose.R_first = so3_exp<double>(Vec3<double>(0.02 * i, random.normal(0.05), 0));
      pose.p_GI = pose.p_first = Vec3<double>(0.1 * i, random.normal(0.05), 0);
      if (i != 3) track.slots |= 1u << slot;
      track.uv[slot] = Vec2<double>(300 + 10 * i, 200 + random.normal(3));
    }
    landmark.o = Vec3<double>::Zero();
    landmark.m = Vec3<double>(0.1, -0.05, 1);
    landmark.rho = 0.3;
  }

  /// What feature_rows() writes, in the columns from the landmark's on.
  Eigen::MatrixXd rows(double walk) {
    const TrackView<double> view = view_of(*w, track);
    const int n = feature_rows(w.get(), view, landmark, 1.0, kSigma, walk, kMaxCameraColumns);
    TEST_ASSERT_EQUAL(2 * (kPoses - 1) + 1, n);
    const int first = pose_column(view.pose[0]) - kLandmarkColumns, last = w->columns() + 1;
    Eigen::MatrixXd out(n, last - first);
    for (int i = 0; i < n; ++i) {
      for (int c = first; c < last; ++c) out(i, c - first) = w->block[i * kBlockStride + c];
    }
    return out;
  }

  /// In units of the white noise; both axes of a point alike, the last row, the prior on distance, by itself.
  Eigen::MatrixXd covariance(double walk) {
    const TrackView<double> view = view_of(*w, track);
    const auto since_first_s = [&](int i) {
      return static_cast<double>(w->pose[view.pose[i]].time - w->pose[view.pose[0]].time) * 1e-9;
    };
    const int n = 2 * view.n + 1;
    Eigen::MatrixXd C = Eigen::MatrixXd::Identity(n, n);
    for (int i = 0; i < 2 * view.n; ++i) {
      for (int j = i % 2; j < 2 * view.n; j += 2)
        C(i, j) += walk * std::min(since_first_s(i / 2), since_first_s(j / 2));
    }
    return C;
  }
};

void check(double walk) {
  const Id id = Id().add("walk_permille", static_cast<int>(1000 * walk));
  Scene scene(11);
  const Eigen::MatrixXd white = scene.rows(0), got = scene.rows(walk);
  const Eigen::MatrixXd expected = white.transpose() * scene.covariance(walk).ldlt().solve(white);
  // Twelve rows of double precision: what rounding leaves is a few times 1e-16 of the largest entry.
  const double difference = (got.transpose() * got - expected).cwiseAbs().maxCoeff();
  test::check_near(id, "information", 0, difference / expected.cwiseAbs().maxCoeff(), 1e-13);
}

/// Whitening by next to nothing leaves what no whitening gives.
void test_without_a_walk_rows_stay() {
  Scene scene(11);
  const Eigen::MatrixXd white = scene.rows(0), got = scene.rows(1e-13);
  test::check_near(Id(), "rows", 0, (got - white).cwiseAbs().maxCoeff() / white.cwiseAbs().maxCoeff(), 1e-12);
}
void test_with_a_small_walk() { check(0.09); }
void test_with_a_large_walk() { check(4.0); }

void test_options_scale_the_walk() {
  VioOptions<double> options;
  options.pixel_sigma = 0.5;
  options.track_walk = 0.3;
  test::check_near(Id(), "walk's variance by the white noise's, 1/s", 0.36, options.walk_variance(), 1e-15);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_without_a_walk_rows_stay);
  RUN_TEST(test_with_a_small_walk);
  RUN_TEST(test_with_a_large_walk);
  RUN_TEST(test_options_scale_the_walk);
  return UNITY_END();
}
