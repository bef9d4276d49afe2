// A lens described by a model that is not its own.
#pragma once

#include "calibration_file.h"

namespace host::experiments {

/// The same camera with the fov model: w and the focal lengths that come closest over the image, least squares in px.
CameraCalibration as_fov(const CameraCalibration& camera);

/// Root mean square distance of the two models' pixels over the image that `b` sees, px.
double lens_difference(const CameraCalibration& a, const CameraCalibration& b);

}  // namespace host::experiments
