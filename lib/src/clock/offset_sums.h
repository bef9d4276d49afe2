// What rotation says about the offset of two clocks, in sums
// over pairs of images, one set for each offset that is tried.
//
// With v the rate that a pair of images shows and w(d) the
// gyroscope's mean rate over the same time moved by d, both in I,
//   B(d) = sum v.w(d),  T(d) = sum |w(d)|^2,  I = sum |v|^2,  correlation r(d) = B / sqrt(T I),
// means taken off in each window of some seconds: a bias of the gyroscope is no rotation. At the peak of r, Q = B - c T
// / 2 with c = B / T has its own: -c Q is half the sum of squares of v - c w(d).
//
// Sigma. A window k has Q_k of its own, whose slope g_k = dQ_k / dd is zero at the offset that this window alone would
// choose. The slopes sum to zero at the peak of all; how they scatter tells how far peaks of single windows lie from
// each other, without looking for any of them:  var d = n / (n - 1) sum g_k^2 / (sum Q_k'')^2.  It holds what changes
// from window to window: noise, parallax, a lens and axes that are slightly wrong. The sums of g_k(i)^2 and g_k(i)
// g_k(i + 1) are kept for each offset i, so that no window is. Slopes of few windows may agree by chance: sigma is at
// least what noise of the size of the residuals does,
//   var d = s^2 / (-c Q''), s^2 = I (1 - r^2) / degrees of freedom.
#pragma once

#include "clock/criteria.h"
#include "math/elementary.h"
#include "math/types.h"

namespace SEGCAL_NS {

/// The sums of the pairs of one window.
template <class S>
struct WindowSums {
  static constexpr int kOffsets = clock_criteria::kOffsets;
  S both[kOffsets], square[kOffsets];  ///< v.w, |w|^2; rad^2/s^2
  Vec3<S> gyro[kOffsets];              ///< sum of w
  Vec3<S> image;                       ///< sum of v
  S image_square;
  std::int32_t pairs;

  void clear() {
    for (int i = 0; i < kOffsets; ++i) {
      both[i] = square[i] = S(0);
      gyro[i].setZero();
    }
    image.setZero();
    image_square = S(0);
    pairs = 0;
  }
  void add(int i, const Vec3<S>& v, const Vec3<S>& w) {
    both[i] += v.dot(w);
    square[i] += w.squaredNorm();
    gyro[i] += w;
  }
  void add_image(const Vec3<S>& v) {
    image += v;
    image_square += v.squaredNorm();
    ++pairs;
  }
  /// After this the sums are about the means.
  void take_means_off() {
    const S share = S(1) / S(pairs);
    for (int i = 0; i < kOffsets; ++i) {
      both[i] -= share * image.dot(gyro[i]);
      square[i] -= share * gyro[i].squaredNorm();
    }
    image_square -= share * image.squaredNorm();
  }
};

template <class S>
struct OffsetPeak {
  int best = 0;    ///< the offset that is tried with the largest correlation
  S steps = S(0);  ///< the peak, in steps from the middle
  S correlation = S(-1), elsewhere = S(-1), at_start = S(0);
  bool inside() const { return best > 1 && best + 2 < clock_criteria::kOffsets; }  ///< slopes on both sides
};

template <class S>
class OffsetSums {
 public:
  static constexpr int kOffsets = clock_criteria::kOffsets;

  std::int32_t windows() const { return windows_; }
  std::int32_t pairs() const { return pairs_; }

  /// A window whose means are off; uses its memory.
  void add(WindowSums<S>* window) {
    S* Q = window->both;
    for (int i = 0; i < kOffsets; ++i) {
      both_[i] += window->both[i];
      square_[i] += window->square[i];
      Q[i] -= S(0.5) * scale(i) * window->square[i];
    }
    S before = S(0);
    for (int i = 1; i + 1 < kOffsets; ++i) {
      const S slope = S(0.5) * (Q[i + 1] - Q[i - 1]);  // per step
      slope_square_[i] += slope * slope;
      if (i > 1) slope_product_[i - 1] += before * slope;
      before = slope;
    }
    image_square_ += window->image_square;
    pairs_ += window->pairs;
    ++windows_;
  }

  OffsetPeak<S> peak() const {
    OffsetPeak<S> out;
    for (int i = 0; i < kOffsets; ++i) {
      const S r = correlation(i);
      if (r > out.correlation) {
        out.correlation = r;
        out.best = i;
      }
    }
    constexpr int lobe = static_cast<int>(clock_criteria::kLobe_s / clock_criteria::kStep_s + 0.5);
    for (int i = 0; i < kOffsets; ++i) {
      if ((i > out.best + lobe || i < out.best - lobe) && correlation(i) > out.elsewhere)
        out.elsewhere = correlation(i);
    }
    out.at_start = correlation(clock_criteria::kStepsEitherWay);
    out.steps = S(out.best - clock_criteria::kStepsEitherWay);
    if (!out.inside()) return out;
    const S l = correlation(out.best - 1), m = correlation(out.best), r = correlation(out.best + 1);
    if (l - S(2) * m + r < S(0))
      out.steps += S(0.5) * (l - r) / (l - S(2) * m + r);  // the top of a parabola through the three
    return out;
  }

  /// Of the peak, in steps; a large number where the sums do not tell.
  S sigma(const OffsetPeak<S>& peak) const {
    if (!peak.inside() || windows_ < 2) return kUnknown;
    const int i = peak.best;
    const S c = scale(i);
    const S bend = (S(2) * both_[i] - both_[i - 1] - both_[i + 1]) -
                   S(0.5) * c * (S(2) * square_[i] - square_[i - 1] - square_[i + 1]);
    const int dof = 3 * (pairs_ - windows_) - 2;
    if (!(bend > S(0)) || dof < 1) return kUnknown;
    const S noise = image_square_ * (S(1) - peak.correlation * peak.correlation) / (S(dof) * c * bend);
    const S scatter = S(windows_) / S(windows_ - 1) * slopes_at(peak) / (bend * bend);
    return square_root(scatter > noise ? scatter : noise);
  }

 private:
  static constexpr S kUnknown = S(1e6);

  S correlation(int i) const {
    const S product = square_[i] * image_square_;
    return square_[i] > S(0) && product > S(0) ? both_[i] / square_root(product) : S(0);
  }
  /// c, kept near 1: far from the peak it means nothing.
  S scale(int i) const {
    const S c = square_[i] > S(0) ? both_[i] / square_[i] : S(1);
    return c < S(0.5) ? S(0.5) : (c > S(2) ? S(2) : c);
  }
  /// Sum of the squared slopes at the peak; each slope is a line between two offsets.
  S slopes_at(const OffsetPeak<S>& peak) const {
    const S beyond = peak.steps - S(peak.best - clock_criteria::kStepsEitherWay);
    const int i = beyond < S(0) ? peak.best - 1 : peak.best;
    const S b = beyond < S(0) ? S(1) + beyond : beyond, a = S(1) - b;
    const S sum = a * a * slope_square_[i] + S(2) * a * b * slope_product_[i] + b * b * slope_square_[i + 1];
    return sum > S(0) ? sum : S(0);
  }

  S both_[kOffsets] = {}, square_[kOffsets] = {};
  S slope_square_[kOffsets] = {}, slope_product_[kOffsets] = {};  ///< g(i)^2, g(i) g(i + 1)
  S image_square_ = S(0);
  std::int32_t windows_ = 0, pairs_ = 0;
};

}  // namespace SEGCAL_NS
