#include "diagnose/pixel_noise.h"

#include <algorithm>
#include <cmath>

#include "diagnose/decision.h"

namespace host::diagnosis {
namespace {

/// Differences of near neighbours, as a straight line over the squared distance: what is smooth in the image differs
/// the more the farther they are apart, noise does not.
class NeighbourPairs {
 public:
  /// `rms`: of the residuals; five times that is far off.
  explicit NeighbourPairs(double rms) : far_off_(5 * rms) {}

  void add_image(const std::vector<const SeenPoint*>& image, const std::vector<int>& views) {
    std::vector<bool> used(image.size(), false);
    for (std::size_t i = 0; i < image.size(); ++i) {
      if (used[i]) continue;
      std::size_t best = i;
      double nearest = kNear;
      for (std::size_t j = i + 1; j < image.size(); ++j) {
        const double d = std::hypot(image[i]->point->u - image[j]->point->u, image[i]->point->v - image[j]->point->v);
        if (used[j] || d >= nearest) continue;
        nearest = d;
        best = j;
      }
      if (best == i) continue;
      used[i] = used[best] = true;
      add(*image[i], *image[best], nearest, views);
    }
  }

  PixelNoise noise() const {
    PixelNoise out;
    out.pairs = pairs_;
    if (pairs_ < 20 || !(w_ > 0)) return out;
    const double det = w_ * xx_ - x_ * x_, mean = y_ / w_;
    const double slope = det > 0 ? (w_ * xy_ - x_ * y_) / det : 0, at_zero = (y_ - slope * x_) / w_;
    const double one = mean * mean;  // variance of a pair's half square, two differences: mean^2
    const double slope_sigma = det > 0 ? std::sqrt(one * w_ / det) : 0;
    const bool sloping = slope > 3 * slope_sigma && at_zero > 0;
    const double variance = sloping ? at_zero : mean;
    const double sigma = sloping ? std::sqrt(one * xx_ / det) : std::sqrt(one / w_);
    out.factor = std::sqrt(variance);
    out.sigma = 0.5 * sigma / out.factor;
    return out;
  }

 private:
  static constexpr double kNear = 80;  // px

  /// A landmark's three unknowns take their share of its residuals.
  static double left(const SeenPoint& s, const std::vector<int>& views) {
    return std::max(0.0, 1 - 1.5 / views[s.point->landmark]);
  }

  void add(const SeenPoint& a, const SeenPoint& b, double distance, const std::vector<int>& views) {
    const CorePointResidual &p = *a.residual, &q = *b.residual;
    if (std::max({std::abs(p.u_sigma), std::abs(p.v_sigma), std::abs(q.u_sigma), std::abs(q.v_sigma)}) > far_off_)
      return;
    const double du = p.u_sigma - q.u_sigma, dv = p.v_sigma - q.v_sigma;
    const double expected = 0.5 * (left(a, views) + left(b, views));
    if (!(expected > 0.2)) return;
    const double y = 0.25 * (du * du + dv * dv) / expected, x = distance * distance;
    ++pairs_;
    w_ += 1;
    x_ += x;
    xx_ += x * x;
    y_ += y;
    xy_ += x * y;
  }

  double far_off_;
  int pairs_ = 0;
  double w_ = 0, x_ = 0, xx_ = 0, y_ = 0, xy_ = 0;
};

}  // namespace

PixelNoise pixel_noise(const std::vector<CoreKept>& kept) {
  const SensorSquares squares = sensor_squares(kept);
  NeighbourPairs pairs(squares.camera_count > 0 ? std::sqrt(squares.camera / squares.camera_count) : 1);
  for (const CoreKept& k : kept) {
    const std::vector<SeenPoint> seen = seen_points(k);
    std::vector<int> views(k.landmarks.size(), 0);
    for (const SeenPoint& s : seen) ++views[s.point->landmark];
    std::vector<std::vector<const SeenPoint*>> images(2 * k.keyframes.size());
    for (const SeenPoint& s : seen) images[2 * s.point->keyframe + (s.point->camera > 0 ? 1 : 0)].push_back(&s);
    for (const auto& image : images) pairs.add_image(image, views);
  }
  return pairs.noise();
}

bool each_track_drifts(const ReplayResult& fit, const PixelNoise& neighbours) {
  const TrackNoise& found = fit.track_noise;
  const SensorSquares squares = sensor_squares(fit.kept);
  const double own = neighbours.factor * neighbours.factor * squares.camera_count;
  const bool by_itself = neighbours.sigma > 0 && own >= decision::kOwnSquares * squares.camera;
  return by_itself && found.points > 0 && found.walk_px_per_sqrt_s >= decision::kWalkOfWhite * found.white_px;
}

}  // namespace host::diagnosis
