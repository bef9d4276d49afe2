#include "outlier_rejection.h"

#include <opencv2/calib3d.hpp>

#include "../camera_geometry.h"

namespace host {
namespace {

constexpr std::size_t min_correspondences = 8;

struct Rays {
  std::vector<cv::Point2d> before, after;
  std::vector<std::size_t> index;  // of the correspondence
};

cv::Point2d to_point(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }

Rays undistorted_pairs(const CameraCalibration& first_camera, const std::vector<cv::Point2f>& before,
                       const CameraCalibration& second_camera, const std::vector<cv::Point2f>& after) {
  Rays rays;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto first = undistort(first_camera, {before[i].x, before[i].y});
    const auto second = undistort(second_camera, {after[i].x, after[i].y});
    if (!first || !second) continue;
    rays.before.push_back(to_point(*first));
    rays.after.push_back(to_point(*second));
    rays.index.push_back(i);
  }
  return rays;
}

}  // namespace

std::vector<bool> epipolar_inliers(const CameraCalibration& first, const std::vector<cv::Point2f>& before,
                                   const CameraCalibration& second, const std::vector<cv::Point2f>& after,
                                   double threshold_px) {
  std::vector<bool> inlier(before.size(), false);
  const Rays rays = undistorted_pairs(first, before, second, after);
  std::vector<unsigned char> agrees(rays.index.size(), 1);
  if (rays.index.size() >= min_correspondences) {
    const double threshold = threshold_px / std::max(second.intrinsics[0], second.intrinsics[1]);
    cv::findFundamentalMat(rays.before, rays.after, cv::FM_RANSAC, threshold, 0.999, 500, agrees);
  }
  for (std::size_t i = 0; i < rays.index.size() && i < agrees.size(); ++i) inlier[rays.index[i]] = agrees[i] != 0;
  return inlier;
}

}  // namespace host
