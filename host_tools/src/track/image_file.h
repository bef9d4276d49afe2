// Images of a recording.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "../calibration_file.h"

namespace host {

/// 8-bit grey, of the calibration's size; throws InputError where the file is none.
cv::Mat read_image(const std::filesystem::path& file, const CameraCalibration& camera);

}  // namespace host
