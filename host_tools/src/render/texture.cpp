#include "texture.h"

#include <opencv2/imgproc.hpp>

namespace host::render {

Texture::Texture(const cv::Mat& picture) {
  CV_Assert(picture.type() == CV_8UC1 && picture.rows == picture.cols && (picture.rows & (picture.rows - 1)) == 0);
  cv::Mat level = picture.clone();
  for (float scale = 1;; scale /= 2) {
    levels_.push_back({{level.begin<std::uint8_t>(), level.end<std::uint8_t>()},
                       static_cast<std::size_t>(level.cols),
                       level.cols - 1,
                       scale});
    if (level.cols == 1) return;
    cv::Mat half;
    cv::resize(level, half, {level.cols / 2, level.rows / 2}, 0, 0, cv::INTER_AREA);  // the mean of each four
    level = half;
  }
}

}  // namespace host::render
