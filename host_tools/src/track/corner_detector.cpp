#include "corner_detector.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace host {
namespace {

constexpr int grid_columns = 8, grid_rows = 5;
constexpr int border_px = 12;  // the tracker's window must lie inside the image

int cell_of(const cv::Point2f& point, const cv::Size& size) {
  const int column = std::clamp(static_cast<int>(point.x) * grid_columns / size.width, 0, grid_columns - 1);
  const int row = std::clamp(static_cast<int>(point.y) * grid_rows / size.height, 0, grid_rows - 1);
  return row * grid_columns + column;
}

/// 255 where a new corner may lie.
cv::Mat free_area(const cv::Size& size, const std::vector<cv::Point2f>& occupied, int distance_px) {
  cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
  const cv::Rect inside(border_px, border_px, size.width - 2 * border_px, size.height - 2 * border_px);
  if (inside.width <= 0 || inside.height <= 0) return mask;
  mask(inside).setTo(255);
  for (const cv::Point2f& point : occupied) cv::circle(mask, point, distance_px, 0, cv::FILLED);
  return mask;
}

/// Strongest first, but a cell takes its second corner only when every other cell had the chance of a first one.
std::vector<cv::Point2f> spread(const std::vector<cv::Point2f>& candidates, std::vector<int> cell_load,
                                const cv::Size& size, std::size_t wanted) {
  std::vector<cv::Point2f> chosen;
  std::vector<bool> taken(candidates.size(), false);
  const int heaviest = static_cast<int>(candidates.size()) + *std::max_element(cell_load.begin(), cell_load.end());
  for (int allowed = 1; allowed <= heaviest && chosen.size() < wanted; ++allowed) {
    for (std::size_t i = 0; i < candidates.size() && chosen.size() < wanted; ++i) {
      int& load = cell_load[static_cast<std::size_t>(cell_of(candidates[i], size))];
      if (taken[i] || load >= allowed) continue;
      taken[i] = true;
      ++load;
      chosen.push_back(candidates[i]);
    }
  }
  return chosen;
}

}  // namespace

std::vector<cv::Point2f> detect_corners(const cv::Mat& image, const std::vector<cv::Point2f>& occupied,
                                        const CornerOptions& options) {
  const int missing = options.max_tracks - static_cast<int>(occupied.size());
  if (missing <= 0) return {};
  std::vector<cv::Point2f> candidates;
  cv::goodFeaturesToTrack(image, candidates, 3 * options.max_tracks, options.quality, options.min_distance_px,
                          free_area(image.size(), occupied, options.min_distance_px), 3);
  if (candidates.empty()) return {};

  std::vector<int> cell_load(grid_columns * grid_rows, 0);
  for (const cv::Point2f& point : occupied) ++cell_load[static_cast<std::size_t>(cell_of(point, image.size()))];
  std::vector<cv::Point2f> corners =
      spread(candidates, std::move(cell_load), image.size(), static_cast<std::size_t>(missing));
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);
  cv::cornerSubPix(image, corners, cv::Size(5, 5), cv::Size(-1, -1), stop);
  return corners;
}

}  // namespace host
