#include "lens_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "image_file.h"
#include "outlier_rejection.h"

namespace host {
namespace {

constexpr std::size_t kPairs = 40;
// From a pinhole to a fisheye of some 200 deg. Between two steps the cost hardly tells which is better.
constexpr double kStep = 0.1;
constexpr int kSteps = 16;

Correspondences follow(const ImageEntry& image, const ImageEntry& next, const CameraCalibration& camera,
                       TrackerOptions options) {
  options.max_epipolar_px = std::numeric_limits<double>::infinity();
  FeatureTracker tracker(camera, 0, options, std::make_shared<std::uint32_t>(0));
  tracker.follow(read_image(image.file, camera));
  tracker.add_corners();
  std::unordered_map<std::uint32_t, cv::Point2f> before;
  for (const Track& track : tracker.tracks()) before.emplace(track.id, track.point);
  tracker.follow(read_image(next.file, camera));
  Correspondences out;
  for (const Track& track : tracker.tracks()) {
    out.before.push_back(before.at(track.id));
    out.after.push_back(track.point);
  }
  return out;
}

double cost_px2(const DivisionLens& lens, const Correspondences& corners, double threshold_px) {
  double sum = 0;
  for (const double d_px : epipolar_distances_px(lens, lens, corners, threshold_px))
    sum += std::pow(std::min(d_px, threshold_px), 2);
  return sum;
}

}  // namespace

double bend_of(const std::vector<Correspondences>& pairs, int width_px, int height_px, double threshold_px) {
  double best = 0, least_px2 = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kSteps; ++step) {
    const double bend = 0 - kStep * step;
    const DivisionLens lens(width_px, height_px, bend);
    double sum_px2 = 0;
    for (const Correspondences& corners : pairs) sum_px2 += cost_px2(lens, corners, threshold_px);
    if (sum_px2 >= least_px2) continue;
    least_px2 = sum_px2;
    best = bend;
  }
  return best;
}

double find_bend(const std::vector<ImageEntry>& images, const CameraCalibration& camera,
                 const TrackerOptions& options) {
  std::vector<Correspondences> pairs;
  const std::size_t n = std::min(kPairs, images.size() - 1);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t at = i * (images.size() - 1) / n;
    pairs.push_back(follow(images[at], images[at + 1], camera, options));
  }
  return bend_of(pairs, camera.width, camera.height, options.max_epipolar_px);
}

}  // namespace host
