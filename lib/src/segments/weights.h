// Measurement model of a segment: noise, priors on nuisance states, robust weights.
#pragma once

#include "segments/landmark_guess.h"
#include "sensors/imu_link.h"

namespace SEGCAL_NS {

template <class S>
struct MeasurementModel {
  ImuNoise<S> imu;
  S pixel_sigma = S(0.5);  ///< px, each axis: white noise of an image point
  S track_walk = S(0);     ///< px/sqrt(s), each axis: random walk along a track (track_noise.h); 0: none
  Vec3<S> g = Vec3<S>(S(0), S(0), S(-9.80665));  ///< m/s^2, in G
  // Weak priors: they keep directions finite that no measurement touches, and are far wider than any real device.
  S bias_a_sigma = S(1);                                ///< m/s^2, accelerometer bias at the start of a partition
  S bias_g_sigma = S(0.5);                              ///< rad/s, gyroscope bias at the start of a partition
  S velocity_sigma = S(30);                             ///< m/s
  S inverse_depth_sigma = kSegmentDepthSigma<S>;        ///< 1/m, about zero
  S turned_inverse_depth_sigma = kTurnedDepthSigma<S>;  ///< 1/m, in a segment whose images show no translation
  /// Of the prior on inverse distance rho, 1/m.
  S depth_sigma(S rho, bool wide) const {
    return rho < S(0) ? kBehindDepthSigma<S> : wide ? turned_inverse_depth_sigma : inverse_depth_sigma;
  }
  S huber = S(3);  ///< whitened length of an image residual above which its weight falls
};

/// Weight and cost of an image residual of squared whitened length e2: quadratic, then linear (Huber).
template <class S>
struct RobustTerm {
  S weight, cost;
};

template <class S>
[[gnu::always_inline]] inline RobustTerm<S> robust_term(const MeasurementModel<S>& model, S e2) {
  const S k = model.huber;
  if (e2 <= k * k) return {S(1), e2};
  const S e = square_root(e2);
  return {k / e, k * (S(2) * e - k)};
}

}  // namespace SEGCAL_NS
