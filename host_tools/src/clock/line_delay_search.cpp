#include "clock/line_delay_search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "clock/criteria.h"
#include "diagnose/gyro_path.h"
#include "diagnose/image_rotation.h"
#include "formatted.h"

namespace host {
namespace {

constexpr int kReadouts = 41;  // tried, from -60 to 60 ms over the whole image: phones have 5 to 35
constexpr double kMostReadout_s = 0.06;
constexpr std::size_t kMostPairs = 480;   // so that the work is bounded
constexpr int kParts = 8;                 // of the recording; left out one after the other for sigma
constexpr double kPixelNoise_rad = 2e-3;  // a pixel of a usual lens: what misfits are large against
constexpr double kSure = 5;               // sigmas
// Least `drop`: 167 recordings with a global shutter have 0.002 at most, also with starts five times as far off as
// devices scatter; 25 ms of read-out have 0.01 in gentle motion, where a filter stands them, and 0.4 shaken by hand.
constexpr double kVisible = 0.01;

using Curve = std::array<double, kReadouts>;

double readout_at(double i) { return kMostReadout_s * (2 * i / (kReadouts - 1) - 1); }

/// Rays of both frames as they would be at the stamp of the first, for the gyroscope's turns between all the instants.
class Pair {
 public:
  Pair(const FramePair& pair, const GyroPath& gyro, const Eigen::Matrix3d& R_CI, const Eigen::Vector3d& b)
      : pair_(pair), gyro_(gyro), R_CI_(R_CI), b_(b), t1_(pair.t1), t2_(pair.t2) {
    R_12_ = gyro.rotation(t1_, t2_, b);
  }

  /// Misfit of a read-out of so many seconds per line, in units of pixel noise; it grows by one per corner.
  double misfit_at(double line_delay) const {
    FramePair turned;
    for (std::size_t i = 0; i < pair_.rays1.size(); ++i) {
      turned.rays1.push_back(turn(t1_, line_delay * pair_.lines1[i]) * (R_CI_.transpose() * pair_.rays1[i]));
      turned.rays2.push_back(turn(t2_, line_delay * pair_.lines2[i]) * (R_CI_.transpose() * pair_.rays2[i]));
    }
    const auto n = static_cast<double>(turned.rays1.size());
    return misfit(turned, R_12_) / (n * kPixelNoise_rad * kPixelNoise_rad);
  }

 private:
  Eigen::Matrix3d turn(double t, double tau) const {
    const Eigen::Vector3d w = gyro_.mean_rate(std::min(t, t + tau), std::max(t, t + tau) + 1e-6);
    return rotation_of(tau * (w - b_));
  }
  const FramePair& pair_;
  const GyroPath& gyro_;
  const Eigen::Matrix3d& R_CI_;
  const Eigen::Vector3d& b_;
  double t1_, t2_;
  Eigen::Matrix3d R_12_;
};

struct Turns {
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();  ///< of the gyroscope, as far as images tell: parallax averages out
  double correlation = 0;                          ///< of the rates of images and gyroscope
};

Turns compare_turns(const std::vector<const FramePair*>& pairs, const GyroPath& gyro, const Eigen::Matrix3d& R_CI) {
  Turns out;
  double both = 0, image = 0, turned = 0;
  for (const FramePair* p : pairs) {
    const Eigen::Vector3d w = gyro.mean_rate(p->t1, p->t2), seen = R_CI.transpose() * rate_by_rotation_alone(*p);
    out.bias += (w - seen) / static_cast<double>(pairs.size());
    both += w.dot(seen);
    image += seen.squaredNorm();
    turned += w.squaredNorm();
  }
  if (image > 0 && turned > 0) out.correlation = both / std::sqrt(image * turned);
  return out;
}

/// Place of the least, between the grid's points; -1: at its end.
double least(const Curve& curve) {
  const auto at = std::min_element(curve.begin(), curve.end()) - curve.begin();
  if (at == 0 || at == kReadouts - 1) return -1;
  const double l = curve[at - 1], m = curve[at], r = curve[at + 1];
  return static_cast<double>(at) + (l - 2 * m + r > 0 ? 0.5 * (l - r) / (l - 2 * m + r) : 0);
}

}  // namespace

bool LineDelaySearch::shows_rolling_shutter() const {
  return judged && std::abs(line_delay) > kSure * sigma && drop > kVisible;
}

LineDelaySearch search_line_delay(const Recording& recording, const CameraCalibration& camera) {
  LineDelaySearch out;
  const GyroPath gyro(recording);
  const std::vector<FramePair> all = frame_pairs(recording, camera);
  std::vector<const FramePair*> pairs;
  const std::size_t stride = 1 + all.size() / kMostPairs;
  for (std::size_t i = 0; i < all.size(); i += stride) {
    if (gyro.covers(all[i].t1 - kMostReadout_s, all[i].t2 + kMostReadout_s)) pairs.push_back(&all[i]);
  }
  const double lines = camera.lines();
  if (!(lines > 0) || pairs.size() < static_cast<std::size_t>(SEGCAL_NS::clock_criteria::kLeastPairs)) return out;
  const Turns turns = compare_turns(pairs, gyro, camera.R_CI);
  // Axes that are wrong, or clocks: what does not turn alike tells nothing of rows.
  if (turns.correlation < SEGCAL_NS::clock_criteria::kLeastCorrelation) return out;
  std::array<Curve, kParts> part{};
  Curve sum{};
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Pair pair(*pairs[k], gyro, camera.R_CI, turns.bias);
    for (int i = 0; i < kReadouts; ++i) {
      const double cost = std::log1p(pair.misfit_at(readout_at(i) / lines));
      part[k * kParts / pairs.size()][static_cast<std::size_t>(i)] += cost;
      sum[static_cast<std::size_t>(i)] += cost;
    }
  }
  const double best = least(sum);
  if (best < 0) return out;
  double squares = 0;
  for (const Curve& left_out : part) {
    Curve others = sum;
    for (std::size_t i = 0; i < kReadouts; ++i) others[i] -= left_out[i];
    const double other = least(others);
    if (other < 0) return out;
    squares += std::pow(readout_at(other) - readout_at(best), 2);
  }
  out.judged = true;
  out.readout_s = readout_at(best);
  out.line_delay = out.readout_s / lines;
  out.sigma = std::sqrt(squares * (kParts - 1) / kParts) / lines;  // jackknife
  out.drop = (sum[kReadouts / 2] - *std::min_element(sum.begin(), sum.end())) / static_cast<double>(pairs.size());
  out.words = formatted(
      "by rotation the camera's %s are exposed one after another, %.1f us each (sigma %.1f), %.0f ms over the image",
      camera.reads_columns ? "columns" : "rows", 1e6 * out.line_delay, 1e6 * out.sigma, 1e3 * out.readout_s);
  return out;
}

LineDelaySearch search_line_delay(const std::vector<Recording>& sessions, const CameraCalibration& camera) {
  LineDelaySearch first = search_line_delay(sessions.front(), camera);
  for (std::size_t i = 1; i < sessions.size() && !first.shows_rolling_shutter(); ++i) {
    const LineDelaySearch found = search_line_delay(sessions[i], camera);
    if (found.shows_rolling_shutter()) return found;
  }
  return first;
}

}  // namespace host
