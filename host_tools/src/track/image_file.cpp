#include "image_file.h"

#include <opencv2/imgcodecs.hpp>

#include "../csv.h"

namespace host {

cv::Mat read_image(const std::filesystem::path& file, const CameraCalibration& camera) {
  expect_regular_file(file);
  const cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  if (image.empty()) throw InputError(file.string() + ": expected an image, found something that cannot be decoded");
  if (image.cols != camera.width || image.rows != camera.height)
    throw InputError(file.string() + ": expected " + std::to_string(camera.width) + " x " +
                     std::to_string(camera.height) + " px as in the calibration, found " + std::to_string(image.cols) +
                     " x " + std::to_string(image.rows));
  return image;
}

}  // namespace host
