// How far items disagree that tell of one theta: the yardstick for another one that may not.
//
// What items leave over is a mean square of 1 per degree of freedom if noise is as stated, and
// g on real recordings, 2 to 20. That excess is not spread evenly: it sits in what the model
// lacks, the scales of a real accelerometer, say. A sum of squares of r numbers of unequal
// variances lambda has longer tails than g times chi-square of r degrees: like one with
//     h = (sum of lambda)^2 / (sum of lambda^2)
// degrees (Satterthwaite, Biometrics Bulletin 2, 1946; Box, Ann. Math. Stat. 25, 1954). Few items cannot tell how
// unequal they are, so the excess is taken to sit in as few directions as one sensor has axes.
#pragma once

#include "math/quantiles.h"

namespace SEGCAL_NS {

/// Directions that hold what segments scatter beyond their noise.
constexpr int kScattering = 3;

template <class S>
class Spread {
 public:
  /// What items left over, a sum of squares of unit variance.
  void add(S square, int degrees) {
    square_ += square;
    degrees_ += degrees;
  }
  void add(const Spread& other) { add(other.square_, other.degrees_); }
  /// Takes it to be no less than `variance`, which more is known of.
  void raise_to(S variance) {
    const S least = variance * S(degrees_);
    if (square_ < least) square_ = least;
  }
  /// Per degree of freedom, and at least 1.
  S mean() const { return square_ > S(degrees_) ? square_ / S(degrees_) : S(1); }

  /// What the ratio of a mean square with `degrees` to mean() exceeds with probability p, all directions alike; zero
  /// where too little is known for a limit.
  S limit(int degrees, S p) const {
    return degrees > 0 && degrees_ > 0 ? f_upper_quantile(degrees, degrees_, p) : S(0);
  }
  /// The same where few directions of each of `items` scatter.
  S uneven_limit(int degrees, S p, int items = 1) const {
    const int h = effective(degrees, kScattering * items);
    return h > 0 && degrees_ > 0 ? f_upper_quantile(h, degrees_ * h / degrees, p) : S(0);
  }

 private:
  int effective(int r, int scattering) const {
    if (r <= scattering) return r;
    const S sum = mean() * S(r), loud = S(1) + (sum - S(r)) / S(scattering);
    return static_cast<int>(sum * sum / (S(scattering) * loud * loud + S(r - scattering)));
  }

  S square_ = S(0);
  std::int32_t degrees_ = 0;
};

}  // namespace SEGCAL_NS
