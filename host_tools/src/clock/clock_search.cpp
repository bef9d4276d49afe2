#include "clock/clock_search.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "clock/criteria.h"
#include "diagnose/clock.h"
#include "diagnose/gyro_path.h"
#include "diagnose/image_rotation.h"

namespace host {
namespace {

using namespace SEGCAL_NS::clock_criteria;

constexpr double significant = 5;

struct Rates {
  std::vector<const FramePair*> pair;
  std::vector<Eigen::Vector3d> image;  ///< rad/s, camera's axes
};

/// Correlation of the rates at an offset, means taken off: a bias of the gyroscope is no rotation.
double correlation_at(const Rates& rates, const GyroPath& gyro, const Eigen::Matrix3d& R_CI, double offset) {
  const auto n = static_cast<double>(rates.pair.size());
  Eigen::Vector3d mean_image = Eigen::Vector3d::Zero(), mean_gyro = Eigen::Vector3d::Zero();
  double both = 0, image = 0, turned = 0;
  for (std::size_t k = 0; k < rates.pair.size(); ++k) {
    const Eigen::Vector3d w = R_CI * gyro.mean_rate(rates.pair[k]->t1 + offset, rates.pair[k]->t2 + offset);
    mean_image += rates.image[k];
    mean_gyro += w;
    both += w.dot(rates.image[k]);
    image += rates.image[k].squaredNorm();
    turned += w.squaredNorm();
  }
  both -= mean_image.dot(mean_gyro) / n;
  image -= mean_image.squaredNorm() / n;
  turned -= mean_gyro.squaredNorm() / n;
  return image > 0 && turned > 0 ? both / std::sqrt(image * turned) : 0;
}

/// Frame pairs that the gyroscope covers at all offsets, so that all are compared on the same motion.
Rates rates_within(const std::vector<FramePair>& pairs, const GyroPath& gyro, double start_s) {
  Rates out;
  for (const FramePair& pair : pairs) {
    if (!gyro.covers(pair.t1 + start_s - kReach_s, pair.t2 + start_s + kReach_s)) continue;
    out.pair.push_back(&pair);
    out.image.push_back(rate_by_rotation_alone(pair));
  }
  return out;
}

double turning(const Rates& rates) {
  double sum = 0;
  for (const Eigen::Vector3d& w : rates.image) sum += w.squaredNorm();
  return std::sqrt(sum / static_cast<double>(rates.image.size()));
}

struct Peak {
  double offset = 0, correlation = 0, elsewhere = -1;
};

Peak find_peak(const std::vector<double>& offsets, const std::vector<double>& correlation) {
  const auto best =
      static_cast<std::size_t>(std::max_element(correlation.begin(), correlation.end()) - correlation.begin());
  Peak out{offsets[best], correlation[best], -1};
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (std::abs(offsets[i] - offsets[best]) > kLobe_s) out.elsewhere = std::max(out.elsewhere, correlation[i]);
  }
  if (best > 0 && best + 1 < offsets.size()) {
    const double l = correlation[best - 1], m = correlation[best], r = correlation[best + 1];
    if (l - 2 * m + r < 0) out.offset += 0.5 * kStep_s * (l - r) / (l - 2 * m + r);
  }
  return out;
}

/// Weighted mean of the windows' offsets (diagnose/clock.h, which knows parallax from rotation); its sigma is at least
/// what their scatter tells. False where no window tells.
bool refine(const std::vector<FramePair>& pairs, const GyroPath& gyro, const Eigen::Matrix3d& R_CI, ClockSearch* out) {
  const std::vector<OffsetInWindow> windows = offsets_over_time(pairs, gyro, R_CI, out->offset_s);
  double weight = 0, sum = 0, scatter = 0;
  for (const OffsetInWindow& w : windows) {
    weight += 1 / (w.sigma * w.sigma);
    sum += w.offset / (w.sigma * w.sigma);
  }
  if (windows.empty()) return false;
  for (const OffsetInWindow& w : windows) scatter += std::pow((w.offset - sum / weight) / w.sigma, 2);
  const double excess = windows.size() > 1 ? std::max(1.0, scatter / static_cast<double>(windows.size() - 1)) : 1;
  out->offset_s = sum / weight;
  out->sigma_s = std::sqrt(excess / weight);
  return true;
}

std::string in_words(const char* format, double a = 0, double b = 0, double c = 0) {
  char text[300];
  std::snprintf(text, sizeof text, format, a, b, c);
  return text;
}

}  // namespace

bool ClockSearch::differs_from(double start_s) const {
  return judged && std::abs(offset_s - start_s) > std::max(clock_systematic_s, significant * sigma_s);
}

ClockSearch search_clock(const Recording& recording, const CameraCalibration& camera, double start_s) {
  ClockSearch out;
  out.offset_s = start_s;
  const GyroPath gyro(recording);
  const std::vector<FramePair> pairs = frame_pairs(recording, camera);
  const Rates rates = rates_within(pairs, gyro, start_s);
  const bool too_few = rates.pair.size() < static_cast<std::size_t>(kLeastPairs);
  if (too_few || turning(rates) < kLeastTurning) {
    out.words = too_few ? "too few images with common corners to compare clocks"
                        : "the device turns too little to compare clocks";
    return out;
  }
  std::vector<double> offsets, correlation;
  for (int i = -kStepsEitherWay; i <= kStepsEitherWay; ++i) {
    offsets.push_back(start_s + i * kStep_s);
    correlation.push_back(correlation_at(rates, gyro, camera.R_CI, offsets.back()));
  }
  const Peak peak = find_peak(offsets, correlation);
  out.correlation = peak.correlation;
  out.correlation_at_start = correlation[offsets.size() / 2];
  if (peak.correlation < kLeastCorrelation) {
    out.words = in_words(
        "rotation of the images and of the gyroscope do not agree at any offset within 0.5 s (correlation %.2f at "
        "best): check R_CI, the axes and the units",
        peak.correlation);
    return out;
  }
  if (1 - peak.correlation > kPeakStandsOut * (1 - peak.elsewhere)) {
    out.words = in_words(
        "the motion repeats itself: offsets of the clocks are not told apart (correlation %.2f, elsewhere %.2f)",
        peak.correlation, peak.elsewhere);
    return out;
  }
  out.judged = true;
  out.offset_s = peak.offset;
  out.sigma_s = kStep_s;
  refine(pairs, gyro, camera.R_CI, &out);
  out.words = in_words("image rotation and gyroscope are shifted by %.1f ms (t_imu = t_cam %+.4f s, sigma %.1f ms)",
                       1e3 * std::abs(out.offset_s), out.offset_s, 1e3 * out.sigma_s);
  return out;
}

void shift_frames(double offset_s, Recording* recording) {
  const auto shift = static_cast<std::int64_t>(std::llround(1e9 * offset_s));
  for (CameraData& camera : recording->cameras)
    for (Frame& frame : camera.frames) frame.t_ns += shift;
}

}  // namespace host
