// How a camera turned between two images, by the rays of the corners that both see: as if it only turned.
//
// Least sum of w |r1 - R r2|^2, w = 1 / (1 + |r1 - R r2|^2 / tolerated^2): what
// moved by parallax or was matched wrongly counts less. With p = R r2 and R <-
// Exp(d) R, r1 - Exp(d) p = r1 - p + p x d to first order, so that each round solves
//   (sum w (I - p p')) d = sum w p x r1.
// The first rounds have all weights 1: they come from no rotation
// at all, where the weights would hold on to what stands still.
#pragma once

#include "clock/criteria.h"
#include "math/small_solvers.h"
#include "math/so3.h"
#include "math/types.h"

namespace SEGCAL_NS {

template <class S>
class TurnBetween {
 public:
  static constexpr int kPlainRounds = 3, kRounds = 8;

  void begin() {
    R_12_.setIdentity();
    round_ = 0;
    clear();
  }
  /// Every pair once in each round: a ray of the first image and one of the second, unit vectors.
  void add(const Vec3<S>& r1, const Vec3<S>& r2) {
    const Vec3<S> p = R_12_ * r2;
    const S tolerated2 = S(clock_criteria::kTolerated * clock_criteria::kTolerated);
    const S w = round_ < kPlainRounds ? S(1) : tolerated2 / (tolerated2 + (r1 - p).squaredNorm());
    information_ += w * (Mat3<S>::Identity() - p * p.transpose());
    pull_ += w * cross<S>(p, r1);
  }
  /// False if the rays do not determine a rotation.
  bool end_round() {
    Mat3<S> L;
    if (!cholesky_lower<S, 3>(information_, &L)) return false;
    Vec3<S> d = pull_;
    forward_substitute<S, 3>(L, d.data());
    back_substitute<S, 3>(L, d.data());
    if (!(d.squaredNorm() < S(10))) return false;  // beyond a half turn, or no number
    R_12_ = renormalised<S>(so3_exp<S>(d) * R_12_);
    ++round_;
    clear();
    return true;
  }
  bool done() const { return round_ == kRounds; }
  /// Of the second image's rays into the first; as a rotation vector, rad.
  Vec3<S> turned() const { return so3_log<S>(R_12_); }

 private:
  void clear() {
    information_.setZero();
    pull_.setZero();
  }

  Mat3<S> R_12_, information_;
  Vec3<S> pull_;
  int round_ = 0;
};

}  // namespace SEGCAL_NS
