#include "wallpaper.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "../simulate/random.h"

namespace host::render {
namespace {

constexpr int largest_patch = 520, smallest_patch = 170;  // px

class Painter {
 public:
  Painter(const Photographs& photographs, std::uint64_t seed)
      : photographs_(photographs), random_(seed, sim::Stream::scene) {}

  /// Halves the patch near its middle until it is small enough.
  void paint(cv::Mat patch) {
    const bool wide = patch.cols >= patch.rows;
    const int length = wide ? patch.cols : patch.rows;
    if (length > largest_patch && length >= 2 * smallest_patch) {
      const int cut =
          std::clamp(static_cast<int>(length * random_.uniform(0.35, 0.65)), smallest_patch, length - smallest_patch);
      paint(wide ? patch.colRange(0, cut) : patch.rowRange(0, cut));
      paint(wide ? patch.colRange(cut, length) : patch.rowRange(cut, length));
      return;
    }
    hang(patch);
  }

 private:
  const cv::Mat& one_of(const std::vector<cv::Mat>& pictures) {
    return pictures[static_cast<std::size_t>(random_.integer(0, static_cast<int>(pictures.size()) - 1))];
  }

  void hang(cv::Mat& patch) {
    const bool plain = random_.uniform() < 0.33;
    cv::Mat picture = one_of(plain ? photographs_.surfaces : photographs_.scenes);
    if (random_.uniform() < 0.25) cv::rotate(picture, picture, cv::ROTATE_90_CLOCKWISE);
    if (random_.uniform() < 0.5) cv::flip(picture, picture, 1);
    const double least =
        std::max(static_cast<double>(patch.cols) / picture.cols, static_cast<double>(patch.rows) / picture.rows);
    const double scale = std::max(least, random_.uniform(0.7, 1.0));
    cv::resize(picture, picture, {}, scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
    const cv::Rect inside(random_.integer(0, std::max(0, picture.cols - patch.cols)),
                          random_.integer(0, std::max(0, picture.rows - patch.rows)),
                          std::min(patch.cols, picture.cols), std::min(patch.rows, picture.rows));
    const double contrast = plain ? random_.uniform(0.1, 0.4) : random_.uniform(0.6, 1.0);
    const double middle = random_.uniform(95, 160);
    cv::Mat cut;
    cv::resize(picture(inside), cut, patch.size());  // the same size but for the last rounding
    cut.convertTo(patch, CV_8U, contrast, middle - contrast * cv::mean(cut)[0]);
  }

  const Photographs& photographs_;
  sim::Random random_;
};

}  // namespace

cv::Mat make_wallpaper(const Photographs& photographs, int side, std::uint64_t seed) {
  cv::Mat wallpaper(side, side, CV_8UC1, cv::Scalar(128));
  Painter(photographs, seed).paint(wallpaper);
  return wallpaper;
}

}  // namespace host::render
