// Corner tracks through a sequence of images of one camera.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <unordered_set>
#include <vector>

#include "../calibration_file.h"
#include "../recording.h"
#include "affine_patch.h"
#include "corner_detector.h"
#include "division_lens.h"

namespace host {

struct TrackerOptions {
  CornerOptions corners;
  int window_px = 17;                    ///< side of the matched patch; wider ones see several depths at once
  int pyramid_levels = 4;                ///< the smallest is 1/8 of the size
  double max_forward_backward_px = 0.5;  ///< distance after tracking there and back
  double max_epipolar_px = 1.0;          ///< largest outlier threshold; infinite: no corner is rejected
  bool equalise = true;                  ///< CLAHE: contrast by region, for dark or unevenly lit scenes
};

struct Track {
  std::uint32_t id;
  cv::Point2f point;                                    ///< in the latest image, px
  std::shared_ptr<const AffinePatch> anchor = nullptr;  ///< what it looked like at first; none where it is new
  Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();  ///< from the anchor to the latest image
  int missed = 0;                                       ///< images in a row in which it did not look like that
};

/// Lucas-Kanade from `start` (of pyramid `from`) to `to`, and back. `found` holds first guesses and then the points.
/// One flag per point: found, at the same place on the way back, and not at the image's edge.
std::vector<bool> tracked_there_and_back(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to,
                                         const std::vector<cv::Point2f>& start, std::vector<cv::Point2f>& found,
                                         const TrackerOptions& options);

/// Pyramidal Lucas-Kanade from image to image, checked backwards; from there onto the corner's first look by an affine
/// fit; checked by RANSAC. A track lasts as long as the corner looks like that; lost corners are replaced by new ones.
/// Identifiers rise from 0 over all cameras that share a counter and are never used twice in one camera. Deterministic:
/// the same images give the same tracks.
class FeatureTracker {
 public:
  /// `bend`: of the camera's DivisionLens. `next_id` counts identifiers; the cameras of one rig share it.
  FeatureTracker(const CameraCalibration& camera, double bend, const TrackerOptions& options,
                 std::shared_ptr<std::uint32_t> next_id);

  /// The corners of the next image: first those that survived, in the order in which they came.
  /// `image` is 8-bit grey and of the calibration's size.
  void follow(const cv::Mat& image);
  /// Then new ones where there are none.
  void add_corners();
  /// A corner found otherwise, with its identifier. Tracks too close to it end, but for those whose identifiers are in
  /// `protected_ids`: where one of these is, nothing changes and the answer is false.
  bool adopt(const Track& track, const std::unordered_set<std::uint32_t>& protected_ids);
  /// The track goes on as another corner.
  void rename(std::uint32_t id);

  const std::vector<Track>& tracks() const { return tracks_; }
  const CameraCalibration& camera() const { return camera_; }
  const DivisionLens& lens() const { return lens_; }
  /// Of the latest image.
  const std::vector<cv::Mat>& pyramid() const { return latest_; }
  std::vector<TrackPoint> points() const;

 private:
  std::vector<cv::Mat> pyramid_of(const cv::Mat& image) const;
  void follow(const std::vector<cv::Mat>& pyramid, const cv::Mat& image);
  bool align(Track& track, const cv::Point2f& before, const cv::Mat& image) const;
  void reject_outliers(const std::vector<cv::Point2f>& before);
  void drop_merged();

  CameraCalibration camera_;
  DivisionLens lens_;
  TrackerOptions options_;
  cv::Ptr<cv::CLAHE> equaliser_;
  cv::Mat latest_image_;         ///< as the camera gave it
  cv::Mat prepared_;             ///< the same with local contrast
  std::vector<cv::Mat> latest_;  ///< its pyramid
  std::vector<Track> tracks_;
  std::shared_ptr<std::uint32_t> next_id_;
};

}  // namespace host
