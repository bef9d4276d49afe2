// Corner tracks through a sequence of images of one camera.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "../calibration_file.h"
#include "../recording.h"
#include "corner_detector.h"

namespace host {

struct TrackerOptions {
  CornerOptions corners;
  int window_px = 17;                     ///< side of the matched patch; wider ones see several depths at once
  int pyramid_levels = 4;                 ///< the smallest is 1/8 of the size
  double max_forward_backward_px = 0.5;   ///< distance after tracking there and back
  double max_epipolar_px = 1.0;           ///< RANSAC threshold
  bool equalise = true;                   ///< CLAHE: contrast by region, for dark or unevenly lit scenes
};

/// Pyramidal Lucas-Kanade from image to image, checked backwards and by RANSAC; lost corners are replaced by new ones.
/// Identifiers rise from 0 and are never used twice. Deterministic: the same images give the same tracks.
class FeatureTracker {
 public:
  FeatureTracker(const CameraCalibration& camera, const TrackerOptions& options);

  /// The corners of the next image: those that survived, in the order of their identifiers, then new ones.
  /// `image` is 8-bit grey and of the calibration's size.
  std::vector<TrackPoint> next(const cv::Mat& image);

 private:
  struct Track {
    std::uint32_t id;
    cv::Point2f point;  ///< in the latest image, px
  };

  std::vector<cv::Mat> pyramid_of(const cv::Mat& image) const;
  void follow(const std::vector<cv::Mat>& pyramid, const cv::Size& size);
  void reject_outliers(const std::vector<cv::Point2f>& before);
  void drop_merged();
  void add_corners(const cv::Mat& image);

  CameraCalibration camera_;
  TrackerOptions options_;
  cv::Ptr<cv::CLAHE> equaliser_;
  std::vector<cv::Mat> previous_;  ///< pyramid of the latest image
  std::vector<Track> tracks_;
  std::uint32_t next_id_ = 0;
};

}  // namespace host
