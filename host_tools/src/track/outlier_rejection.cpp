#include "outlier_rejection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <optional>

namespace host {
namespace {

constexpr std::size_t min_correspondences = 8;
// Of the distances of one pair of images, which are larger where the image moves fast: Rousseeuw and Leroy, "Robust
// regression and outlier detection", 1987, chapter 5. At rest all agree to a hundredth of a pixel: less than a fifth is
// never an outlier.
constexpr double kSigmas = 2.5, kSigmaOfMedian = 1.4826, kLeast_px = 0.2;
constexpr double min_forward = 0.2;  // of a ray: OpenCV needs points of a plane, and stretches what is near its edge

Eigen::Vector2d to_vector(const cv::Point2f& p) { return {p.x, p.y}; }
cv::Point2d on_plane(const Eigen::Vector3d& ray) { return {ray.x() / ray.z(), ray.y() / ray.z()}; }

/// ray_after' F ray_before = 0, over the two slopes of this by the pixel.
double distance_px(const Eigen::Matrix3d& F, const DivisionLens& first, const DivisionLens& second,
                   const cv::Point2f& before, const cv::Point2f& after) {
  const Eigen::Vector2d x = to_vector(before), y = to_vector(after);
  const Eigen::Vector3d in_second = F * first.ray(x), in_first = F.transpose() * second.ray(y);
  const double slope = std::min((second.ray_by_pixel(y).transpose() * in_second).norm(),
                                (first.ray_by_pixel(x).transpose() * in_first).norm());
  return std::abs(second.ray(y).dot(in_second)) / std::max(slope, 1e-12);
}

struct PlanePoints {
  std::vector<cv::Point2d> before, after;
};

PlanePoints plane_points(const DivisionLens& first, const DivisionLens& second, const Correspondences& corners) {
  PlanePoints out;
  for (std::size_t i = 0; i < corners.before.size(); ++i) {
    const Eigen::Vector3d x = first.ray(to_vector(corners.before[i])), y = second.ray(to_vector(corners.after[i]));
    if (x.z() < min_forward || y.z() < min_forward) continue;
    out.before.push_back(on_plane(x));
    out.after.push_back(on_plane(y));
  }
  return out;
}

Eigen::Matrix3d to_eigen(const cv::Mat& F) {
  Eigen::Matrix3d out;
  for (int i = 0; i < 9; ++i) out(i / 3, i % 3) = F.at<double>(i / 3, i % 3);
  return out;
}

/// Of the points that `F` keeps, by `method` of OpenCV; empty where it finds none.
std::optional<Eigen::Matrix3d> fundamental(const PlanePoints& points, int method, double threshold) {
  if (points.before.size() < min_correspondences) return std::nullopt;
  const cv::Mat F = cv::findFundamentalMat(points.before, points.after, method, threshold, 0.999, 500);
  if (F.rows != 3 || F.cols != 3) return std::nullopt;
  return to_eigen(F);
}

Correspondences within(const Correspondences& corners, const std::vector<double>& distances_px, double threshold_px) {
  Correspondences out;
  for (std::size_t i = 0; i < distances_px.size(); ++i) {
    if (distances_px[i] > threshold_px) continue;
    out.before.push_back(corners.before[i]);
    out.after.push_back(corners.after[i]);
  }
  return out;
}

}  // namespace

std::vector<double> epipolar_distances_px(const DivisionLens& first, const DivisionLens& second,
                                          const Correspondences& corners, double threshold_px) {
  const auto by = [&](const Eigen::Matrix3d& F) {
    std::vector<double> out;
    for (std::size_t i = 0; i < corners.before.size(); ++i)
      out.push_back(distance_px(F, first, second, corners.before[i], corners.after[i]));
    return out;
  };
  const auto sampled =
      fundamental(plane_points(first, second, corners), cv::FM_RANSAC, threshold_px / second.half_diagonal_px());
  if (!sampled) return std::vector<double>(corners.before.size(), 0);
  const std::vector<double> distances_px = by(*sampled);
  const Correspondences agree = within(corners, distances_px, threshold_px);
  const auto fitted = fundamental(plane_points(first, second, agree), cv::FM_8POINT, 0);
  if (!fitted) return distances_px;
  const std::vector<double> refined_px = by(*fitted);
  return within(corners, refined_px, threshold_px).before.size() >= agree.before.size() ? refined_px : distances_px;
}

double outlier_threshold_px(std::vector<double> distances_px, double most_px) {
  if (distances_px.empty()) return most_px;
  const auto middle = distances_px.begin() + static_cast<std::ptrdiff_t>(distances_px.size() / 2);
  std::nth_element(distances_px.begin(), middle, distances_px.end());
  return std::clamp(kSigmas * kSigmaOfMedian * *middle, std::min(kLeast_px, most_px), most_px);
}

std::vector<bool> epipolar_inliers(const DivisionLens& first, const DivisionLens& second,
                                   const Correspondences& corners, double most_px) {
  const std::vector<double> distances_px = epipolar_distances_px(first, second, corners, most_px);
  const double threshold_px = outlier_threshold_px(distances_px, most_px);
  std::vector<bool> out;
  for (const double d_px : distances_px) out.push_back(d_px <= threshold_px);
  return out;
}

}  // namespace host
