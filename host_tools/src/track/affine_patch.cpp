#include "affine_patch.h"

#include <algorithm>
#include <cmath>

namespace host {
namespace {

constexpr int max_steps = 20;  // it settles within 4 to 8 or not at all
// a third of the noise of a step of a track; 0.003 px is not reached in a third of the patches
constexpr float settled_px = 0.02F;
// below it the patch shows something else; 0.9 gives rendered tracks as good, and shorter real ones
constexpr float least_correlation = 0.8F;
constexpr float most_scale = 2;   // beyond it one of the two images has no detail that the other could show
constexpr float most_gain = 5;    // of brightness: a patch in a shadow
constexpr double damping = 1e-6;  // a patch of one grey level has no gradient, and no answer

float at(const cv::Mat& image, int x, int y) {
  return image.at<unsigned char>(std::min(std::max(y, 0), image.rows - 1), std::min(std::max(x, 0), image.cols - 1));
}

/// Bilinear; outside, the rim.
float at(const cv::Mat& image, const Eigen::Vector2f& point) {
  const float fx = std::floor(point.x()), fy = std::floor(point.y());
  const int x = static_cast<int>(fx), y = static_cast<int>(fy);
  const float ax = point.x() - fx, ay = point.y() - fy;
  if (x >= 0 && y >= 0 && x + 1 < image.cols && y + 1 < image.rows) {
    const unsigned char* const upper = image.ptr<unsigned char>(y) + x;
    const unsigned char* const lower = image.ptr<unsigned char>(y + 1) + x;
    return (1 - ay) * ((1 - ax) * upper[0] + ax * upper[1]) + ay * ((1 - ax) * lower[0] + ax * lower[1]);
  }
  return (1 - ay) * ((1 - ax) * at(image, x, y) + ax * at(image, x + 1, y)) +
         ay * ((1 - ax) * at(image, x, y + 1) + ax * at(image, x + 1, y + 1));
}

/// Neither mirrored nor stretched or shrunk by more than the limit:
/// singular values s1 >= s2 have s1^2 + s2^2 = |A|^2 and s1 s2 = det A.
bool plausible(const Eigen::Matrix2f& A) {
  const float area = A.determinant(), squares = A.squaredNorm(), limit = 2 * most_scale * most_scale;
  return area > 0 && squares < limit && squares < limit * area * area;
}

}  // namespace

AffinePatch::AffinePatch(const cv::Mat& image, const Eigen::Vector2f& point, int side_px) : half_(side_px / 2) {
  const int cx = static_cast<int>(std::lround(point.x())), cy = static_cast<int>(std::lround(point.y()));
  offset_ = point - Eigen::Vector2f(static_cast<float>(cx), static_cast<float>(cy));
  const int n = side_px * side_px;
  Eigen::Matrix<double, Eigen::Dynamic, kUnknowns> J(n, kUnknowns);
  grey_.resize(n);
  for (int dy = -half_, i = 0; dy <= half_; ++dy) {
    for (int dx = -half_; dx <= half_; ++dx, ++i) {
      const int x = cx + dx, y = cy + dy;
      const double gx = 0.5 * (at(image, x + 1, y) - at(image, x - 1, y)),
                   gy = 0.5 * (at(image, x, y + 1) - at(image, x, y - 1));
      grey_[i] = at(image, x, y);
      J.row(i) << gx * dx, gx * dy, gx, gy * dx, gy * dy, gy, 0, 1;
    }
  }
  grey_.array() -= grey_.mean();
  J.col(kGain) = grey_.cast<double>();
  Eigen::Matrix<double, kUnknowns, kUnknowns> H = J.transpose() * J;
  H.diagonal() *= 1 + damping;
  step_ = H.ldlt().solve(J.transpose()).cast<float>();
}

void AffinePatch::sample(const cv::Mat& image, const Map& W, Eigen::VectorXf& seen) const {
  for (int dy = -half_, i = 0; dy <= half_; ++dy)
    for (int dx = -half_; dx <= half_; ++dx, ++i)
      seen[i] = at(image, W.t + W.A * Eigen::Vector2f(static_cast<float>(dx), static_cast<float>(dy)));
}

/// seen(x) = gain * patch(D x) + offset with D near 1, to first
/// order in D; the map is then W D^-1 (equation 37 of the source).
bool AffinePatch::step(const Eigen::VectorXf& seen, Map& W) const {
  const Eigen::Matrix<float, kUnknowns, 1> u = step_ * seen;
  const float gain = u[kGain];
  if (!(gain > 1 / most_gain && gain < most_gain)) return false;
  Eigen::Matrix2f D;
  D << 1 + u[0] / gain, u[1] / gain, u[3] / gain, 1 + u[4] / gain;
  W.A = W.A * D.inverse();
  W.t -= W.A * Eigen::Vector2f(u[2], u[5]) / gain;
  return W.t.allFinite() && plausible(W.A);
}

bool AffinePatch::looks_like(Eigen::VectorXf& seen) const {
  seen.array() -= seen.mean();
  return seen.dot(grey_) > least_correlation * seen.norm() * grey_.norm();
}

bool AffinePatch::align(const cv::Mat& image, PatchPose& pose) const {
  Map W{pose.shape, pose.point - pose.shape * offset_};
  Eigen::VectorXf seen(grey_.size());
  Eigen::Vector2f point = pose.point;
  for (int k = 0; k < max_steps; ++k) {
    sample(image, W, seen);
    if (!step(seen, W)) return false;
    const Eigen::Vector2f before = point;
    point = W.t + W.A * offset_;
    if (!((point - pose.point).norm() < static_cast<float>(half_))) return false;  // ran away
    if ((point - before).norm() > settled_px) continue;
    if (!looks_like(seen)) return false;
    pose = {point, W.A};
    return true;
  }
  return false;
}

}  // namespace host
