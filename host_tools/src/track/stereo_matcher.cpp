#include "stereo_matcher.h"

#include <Eigen/Geometry>
#include <unordered_map>

#include "../camera_geometry.h"
#include "outlier_rejection.h"

namespace host {
namespace {

constexpr std::size_t fewest_pairs = 12;  // an epipolar geometry has seven unknowns: fewer pairs prove nothing
// One number for a lens leaves epipolar lines bent by some pixels where the two places in the images are far apart.
constexpr double threshold_px = 3;

/// Where a point far away is seen in the second camera; empty where it is not in the image.
std::optional<cv::Point2f> far_point(const CameraCalibration& first, const CameraCalibration& second,
                                     const cv::Point2f& point) {
  const auto ray = undistort(first, {point.x, point.y});
  if (!ray) return std::nullopt;
  const Eigen::Vector3d seen = second.R_CI * (first.R_CI.transpose() * ray->homogeneous());
  if (seen.z() < 0.2 * seen.norm()) return std::nullopt;
  const Eigen::Vector2d pixel = distort(second, seen.hnormalized());
  if (!(pixel.x() > 0 && pixel.y() > 0 && pixel.x() < second.width && pixel.y() < second.height)) return std::nullopt;
  return cv::Point2f(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
}

std::vector<cv::Point2f> places(const std::vector<Track>& tracks) {
  std::vector<cv::Point2f> points;
  for (const Track& track : tracks) points.push_back(track.point);
  return points;
}

}  // namespace

StereoMatcher::Pairs StereoMatcher::known_pairs(const FeatureTracker& first, const FeatureTracker& second) const {
  std::unordered_map<std::uint32_t, Track> by_id;
  for (const Track& track : second.tracks()) by_id.emplace(track.id, track);
  Pairs pairs;
  for (const Track& track : first.tracks()) {
    const auto same = by_id.find(track.id);
    if (same == by_id.end()) continue;
    pairs.first.push_back(track);
    pairs.second.push_back(same->second);
  }
  return pairs;
}

/// Of the first camera's tracks that have no partner.
void StereoMatcher::add_new_pairs(const FeatureTracker& first, const FeatureTracker& second, Pairs& pairs) const {
  std::unordered_set<std::uint32_t> paired;
  for (const Track& track : pairs.first) paired.insert(track.id);
  std::vector<Track> candidates;
  std::vector<cv::Point2f> found;
  for (const Track& track : first.tracks()) {
    if (paired.count(track.id) != 0) continue;
    const auto guess = far_point(first.camera(), second.camera(), track.point);
    if (!guess) continue;
    candidates.push_back(track);
    found.push_back(*guess);
  }
  const auto good = tracked_there_and_back(first.pyramid(), second.pyramid(), places(candidates), found, options_);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!good[i]) continue;
    pairs.first.push_back(candidates[i]);
    pairs.second.push_back({candidates[i].id, found[i]});
  }
}

void StereoMatcher::match(const FeatureTracker& first, FeatureTracker& second) const {
  Pairs pairs = known_pairs(first, second);
  const std::size_t known = pairs.first.size();
  add_new_pairs(first, second, pairs);
  if (pairs.first.size() < fewest_pairs) return;
  const auto agrees =
      epipolar_inliers(first.lens(), second.lens(), {places(pairs.first), places(pairs.second)}, threshold_px);
  std::unordered_set<std::uint32_t> shared;
  for (std::size_t i = 0; i < known; ++i) {
    if (agrees[i]) {
      shared.insert(pairs.second[i].id);
    } else {
      second.rename(pairs.second[i].id);
    }
  }
  for (std::size_t i = known; i < pairs.first.size(); ++i)
    if (agrees[i] && second.adopt(pairs.second[i], shared)) shared.insert(pairs.second[i].id);
}

}  // namespace host
