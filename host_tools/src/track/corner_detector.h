// New corners where the image has none yet.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace host {

struct CornerOptions {
  int max_tracks = 120;      ///< corners wanted in the whole image, old and new
  int min_distance_px = 20;  ///< between two corners
  double quality = 0.01;     ///< weakest corner accepted, as a share of the strongest one's smaller eigenvalue
};

/// Shi-Tomasi corners, refined to sub-pixel, away from `occupied`, so that both together are at most max_tracks and
/// cover the image: emptier cells of a grid are served first. `image` is 8-bit grey. Strongest first within each round.
std::vector<cv::Point2f> detect_corners(const cv::Mat& image, const std::vector<cv::Point2f>& occupied,
                                        const CornerOptions& options);

}  // namespace host
