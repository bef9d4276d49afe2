// A corner whose surroundings are bent: where the affine fit puts it,
// against where it is, and what a patch that is only shifted makes of it.
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "../support/cases.h"
#include "track/affine_patch.h"

namespace {

constexpr int kSide = 17;  // px, the tracker's
const cv::Point2f corner(80.3F, 79.6F);

/// Blobs of some 5 px: what a camera sees of a textured wall.
cv::Mat texture(int seed) {
  cv::RNG random(static_cast<std::uint64_t>(seed));
  cv::Mat noise(160, 160, CV_32F), grey;
  random.fill(noise, cv::RNG::NORMAL, 0, 1);
  cv::GaussianBlur(noise, noise, cv::Size(), 2.0);
  cv::normalize(noise, noise, 20, 235, cv::NORM_MINMAX);
  noise.convertTo(grey, CV_8U);
  return grey;
}

/// The corner's surroundings by A, and the corner moved by `way`.
cv::Mat bent(const cv::Mat& image, const Eigen::Matrix2f& A, const Eigen::Vector2f& way, float gain) {
  const Eigen::Vector2f c(corner.x, corner.y), t = c + way - A * c;
  const cv::Matx23f map(A(0, 0), A(0, 1), t.x(), A(1, 0), A(1, 1), t.y());
  cv::Mat out;
  cv::warpAffine(image, out, map, image.size(), cv::INTER_CUBIC);
  out.convertTo(out, CV_8U, gain, 10);
  return out;
}

void a_bent_patch() {
  Eigen::Matrix2f A;
  A << 1.2F, 0.08F, -0.05F, 0.9F;
  const Eigen::Vector2f way(0.8F, -0.6F);
  double squares = 0, squares_shifted = 0;
  int found = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    const cv::Mat first = texture(seed), second = bent(first, A, way, 0.8F);
    host::PatchPose pose{{corner.x, corner.y}};
    if (!host::AffinePatch(first, pose.point, kSide).align(second, pose)) continue;
    const Eigen::Vector2f truth = Eigen::Vector2f(corner.x, corner.y) + way;
    ++found;
    squares += (pose.point - truth).squaredNorm();
    test::check_near(test::Id().add("seed", seed), "shape", 0, (pose.shape - A).norm(),
                     0.03);  // grey levels are whole numbers: 0.01
    std::vector<cv::Point2f> shifted{corner};
    std::vector<unsigned char> status;
    cv::calcOpticalFlowPyrLK(first, second, std::vector<cv::Point2f>{corner}, shifted, status, cv::noArray(),
                             cv::Size(kSide, kSide), 0);
    squares_shifted += (Eigen::Vector2f(shifted[0].x, shifted[0].y) - truth).squaredNorm();
  }
  const double rms = std::sqrt(squares / found), rms_shifted = std::sqrt(squares_shifted / found);
  std::printf("%d of 20, rms %.3f px; only shifted %.3f px\n", found, rms, rms_shifted);
  TEST_ASSERT_GREATER_OR_EQUAL(18, found);  // blobs that hardly have a corner may not settle
  test::check_near(test::Id().add("seeds", 20), "point, px rms", 0, rms,
                   0.05);  // interpolation, whole grey levels: 0.02
  TEST_ASSERT_TRUE_MESSAGE(rms_shifted > 4 * rms, "a patch that is only shifted is as good: nothing was bent here");
}

void something_else() {
  host::PatchPose pose{{corner.x, corner.y}};
  const host::AffinePatch patch(texture(1), pose.point, kSide);
  for (int seed = 2; seed <= 20; ++seed) {
    TEST_ASSERT_FALSE_MESSAGE(patch.align(texture(seed), pose), test::Id().add("seed", seed).text().c_str());
    TEST_ASSERT_EQUAL_FLOAT(corner.x, pose.point.x());
    TEST_ASSERT_TRUE(pose.shape.isIdentity());
  }
}

void no_texture_and_the_rim() {
  const cv::Mat flat(40, 40, CV_8U, cv::Scalar(90));
  host::PatchPose pose{{20, 20}};
  TEST_ASSERT_FALSE(host::AffinePatch(flat, pose.point, kSide).align(flat, pose));
  const cv::Mat image = texture(3);
  host::PatchPose corner_of_image{{2, 157}};
  TEST_ASSERT_TRUE(host::AffinePatch(image, corner_of_image.point, kSide).align(image, corner_of_image));
  test::check_near(test::Id().add("seed", 3), "at the rim", 0, (corner_of_image.point - Eigen::Vector2f(2, 157)).norm(),
                   0.01);
}

}  // namespace

void setUp() {}
void tearDown() {}

int main() {
  UNITY_BEGIN();
  RUN_TEST(a_bent_patch);
  RUN_TEST(something_else);
  RUN_TEST(no_texture_and_the_rim);
  return UNITY_END();
}
