#include "feature_tracker.h"

#include <algorithm>
#include <cmath>
#include <opencv2/video/tracking.hpp>

#include "outlier_rejection.h"

namespace host {
namespace {

constexpr float rim_px = 8;  // closer to the edge than this the patch is mostly outside
// from a step of Lucas-Kanade, which errs by 0.1 to 0.4 px: farther off it is another corner
constexpr float max_alignment_px = 1.5F;
constexpr int most_missed = 3;   // images in a row: one or two may be blurred
constexpr double merged_px = 4;  // closer to each other than this two tracks share most of their patch

bool inside(const cv::Point2f& point, const cv::Size& size) {
  return point.x >= rim_px && point.y >= rim_px && point.x < size.width - rim_px && point.y < size.height - rim_px;
}

double distance_px(const cv::Point2f& a, const cv::Point2f& b) { return cv::norm(a - b); }

/// Lucas-Kanade until the step is a thousandth of a pixel: a looser stop adds to the noise of each step of a track.
std::vector<unsigned char> lucas_kanade(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to,
                                        const std::vector<cv::Point2f>& start, std::vector<cv::Point2f>& found,
                                        const TrackerOptions& options) {
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 0.001);
  std::vector<unsigned char> status;
  cv::calcOpticalFlowPyrLK(from, to, start, found, status, cv::noArray(),
                           cv::Size(options.window_px, options.window_px), options.pyramid_levels - 1, stop,
                           cv::OPTFLOW_USE_INITIAL_FLOW, 1e-4);
  return status;
}

}  // namespace

std::vector<bool> tracked_there_and_back(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to,
                                         const std::vector<cv::Point2f>& start, std::vector<cv::Point2f>& found,
                                         const TrackerOptions& options) {
  std::vector<bool> good(start.size(), false);
  if (start.empty()) return good;
  std::vector<cv::Point2f> back = start;
  const auto forward_ok = lucas_kanade(from, to, start, found, options);
  const auto backward_ok = lucas_kanade(to, from, found, back, options);
  const cv::Size size = to.front().size();
  for (std::size_t i = 0; i < start.size(); ++i)
    good[i] = forward_ok[i] && backward_ok[i] && inside(found[i], size) &&
              distance_px(start[i], back[i]) <= options.max_forward_backward_px;
  return good;
}

FeatureTracker::FeatureTracker(const CameraCalibration& camera, double bend, const TrackerOptions& options,
                               std::shared_ptr<std::uint32_t> next_id)
    : camera_(camera), lens_(camera.width, camera.height, bend), options_(options), next_id_(std::move(next_id)) {
  if (options.equalise) equaliser_ = cv::createCLAHE(2.0, cv::Size(8, 8));
}

void FeatureTracker::follow(const cv::Mat& image) {
  prepared_ = image;
  if (equaliser_) {
    prepared_ = cv::Mat();
    equaliser_->apply(image, prepared_);
  }
  std::vector<cv::Mat> pyramid = pyramid_of(prepared_);
  if (!tracks_.empty()) follow(pyramid, image);
  latest_ = std::move(pyramid);
  latest_image_ = image;
}

std::vector<TrackPoint> FeatureTracker::points() const {
  std::vector<TrackPoint> points;
  for (const Track& track : tracks_) points.push_back({track.id, track.point.x, track.point.y});
  return points;
}

std::vector<cv::Mat> FeatureTracker::pyramid_of(const cv::Mat& image) const {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(image, pyramid, cv::Size(options_.window_px, options_.window_px),
                              options_.pyramid_levels - 1);
  return pyramid;
}

void FeatureTracker::follow(const std::vector<cv::Mat>& pyramid, const cv::Mat& image) {
  std::vector<cv::Point2f> before;
  for (const Track& track : tracks_) before.push_back(track.point);
  std::vector<cv::Point2f> after = before;
  const std::vector<bool> good = tracked_there_and_back(latest_, pyramid, before, after, options_);
  std::vector<Track> kept;
  std::vector<cv::Point2f> kept_before;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!good[i]) continue;
    Track track = tracks_[i];
    track.point = after[i];
    if (!align(track, before[i], image)) continue;
    kept.push_back(track);
    kept_before.push_back(before[i]);
  }
  tracks_ = std::move(kept);
  reject_outliers(kept_before);
  drop_merged();
}

/// Lucas-Kanade has put it near: from there onto what the corner looked like at
/// first. False where it has not looked like that for some images. The grey values
/// are those of the camera: local contrast changes with the place in the image.
bool FeatureTracker::align(Track& track, const cv::Point2f& before, const cv::Mat& image) const {
  const bool first = !track.anchor;
  if (first)
    track.anchor =
        std::make_shared<AffinePatch>(latest_image_, Eigen::Vector2f(before.x, before.y), options_.window_px);
  const Eigen::Vector2f start(track.point.x, track.point.y);
  PatchPose pose{start, track.shape};
  if (!track.anchor->align(image, pose) || (pose.point - start).norm() > max_alignment_px)
    return !first && ++track.missed < most_missed;
  track.point = {pose.point.x(), pose.point.y()};
  track.shape = pose.shape;
  track.missed = 0;
  return true;
}

void FeatureTracker::reject_outliers(const std::vector<cv::Point2f>& before) {
  if (!std::isfinite(options_.max_epipolar_px)) return;  // all are wanted
  Correspondences corners{before, {}};
  for (const Track& track : tracks_) corners.after.push_back(track.point);
  const std::vector<bool> inlier = epipolar_inliers(lens_, lens_, corners, options_.max_epipolar_px);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    if (inlier[i]) tracks_[kept++] = tracks_[i];
  tracks_.resize(kept);
}

/// Two tracks that ran into each other follow the same corner: the older one stays.
void FeatureTracker::drop_merged() {
  std::vector<Track> kept;
  for (const Track& track : tracks_) {
    const auto same = [&](const Track& other) { return distance_px(other.point, track.point) < merged_px; };
    if (std::none_of(kept.begin(), kept.end(), same)) kept.push_back(track);
  }
  tracks_ = std::move(kept);
}

void FeatureTracker::add_corners() {
  std::vector<cv::Point2f> occupied;
  for (const Track& track : tracks_) occupied.push_back(track.point);
  for (const cv::Point2f& corner : detect_corners(prepared_, occupied, options_.corners))
    if (inside(corner, prepared_.size())) tracks_.push_back({(*next_id_)++, corner});
}

bool FeatureTracker::adopt(const Track& track, const std::unordered_set<std::uint32_t>& protected_ids) {
  const auto close = [&](const Track& other) {
    return distance_px(other.point, track.point) < options_.corners.min_distance_px;
  };
  const auto in_the_way = [&](const Track& other) { return close(other) && protected_ids.count(other.id) != 0; };
  if (std::any_of(tracks_.begin(), tracks_.end(), in_the_way)) return false;
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), close), tracks_.end());
  tracks_.push_back(track);
  return true;
}

void FeatureTracker::rename(std::uint32_t id) {
  for (Track& track : tracks_)
    if (track.id == id) track.id = (*next_id_)++;
}

}  // namespace host
