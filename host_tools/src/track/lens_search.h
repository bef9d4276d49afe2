// How strongly a lens bends straight lines, from corners of an image and the next.
#pragma once

#include "../recording.h"
#include "feature_tracker.h"
#include "outlier_rejection.h"

namespace host {

/// The `bend` (DivisionLens), to 0.1, with which all pairs of images agree best with epipolar geometries: the least sum
/// of squared distances, none counted with more than `threshold_px`.
double bend_of(const std::vector<Correspondences>& pairs, int width_px, int height_px, double threshold_px);

/// Of forty pairs from the whole recording. Tracks that are checked with it do not depend on a calibration, which is
/// still to be found.
double find_bend(const std::vector<ImageEntry>& images, const CameraCalibration& camera, const TrackerOptions& options);

}  // namespace host
