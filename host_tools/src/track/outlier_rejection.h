// Which correspondences between two images, of one camera or of two, agree with one epipolar geometry.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "../calibration_file.h"

namespace host {

/// RANSAC with a fundamental matrix on normalised, undistorted coordinates; the threshold is `threshold_px` over the
/// focal length. Its seven degrees of freedom take up an intrinsic calibration that is some per cent off, as a start
/// may be, so good tracks are not lost to it. Fewer than 8 correspondences with a ray are all accepted: they prove
/// nothing. Returns one flag per correspondence; one without a ray in front of the camera is rejected.
std::vector<bool> epipolar_inliers(const CameraCalibration& first, const std::vector<cv::Point2f>& before,
                                   const CameraCalibration& second, const std::vector<cv::Point2f>& after,
                                   double threshold_px);

}  // namespace host
