// Which correspondences between two images, of one camera or of two, agree with one epipolar geometry.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "division_lens.h"

namespace host {

/// The same corners in two images, px.
struct Correspondences {
  std::vector<cv::Point2f> before, after;
};

/// Per correspondence, how far it is from the epipolar curves of one fundamental matrix (RANSAC, then by all that
/// agree), px; the larger of both images. Its seven degrees of freedom take up the principal point and the focal
/// length. Fewer than 8 correspondences are all at 0: they prove nothing.
std::vector<double> epipolar_distances_px(const DivisionLens& first, const DivisionLens& second,
                                          const Correspondences& corners, double threshold_px);

/// Two and a half robust sigmas of the distances, between 0.2 px and `most_px`.
double outlier_threshold_px(std::vector<double> distances_px, double most_px);

/// One flag per correspondence: not an outlier by outlier_threshold_px().
std::vector<bool> epipolar_inliers(const DivisionLens& first, const DivisionLens& second,
                                   const Correspondences& corners, double most_px);

}  // namespace host
