// A device with a known theta, and segments' information about it, drawn: for tests of what segments say of each other.
#pragma once

#include "calibration/prior.h"
#include "information/segment_information.h"
#include "random.h"

namespace test {

/// Theta is the prior's mean plus `truth` of the prior's sigmas.
struct DrawnTheta {
  using S = float;
  SEGCAL_NS::Calibration<S> theta;
  SEGCAL_NS::ThetaPrior<S> prior;
  Random random;
  double truth[SEGCAL_NS::kMaxTheta] = {};

  explicit DrawnTheta(std::uint32_t seed) : random(seed) {
    theta.n_cameras = 1;
    prior.mean = theta;
    default_prior_sigmas(prior.mean, prior.sigma);
  }
  int n() const { return theta.columns(); }

  /// R (theta [-] theta_0) = d with noise of that standard deviation;
  /// `entry(i, c)`: of R, in units of 1 / (sigma of the prior).
  template <class Entry>
  SEGCAL_NS::SegmentInformation<S> information(double noise, Entry entry) {
    SEGCAL_NS::SegmentInformation<S> s;
    s.n_theta = n();
    s.dof = 1000;
    SEGCAL_NS::PackedTriangle<S> T = s.triangle();
    T.clear();
    for (int i = 0; i < n(); ++i) {
      double d = random.normal(noise);
      for (int c = i; c < n(); ++c) {
        const double r = entry(i, c);
        d += r * truth[c];
        T.row(i)[c] = static_cast<S>(r / static_cast<double>(prior.sigma[c]));
      }
      T.row(i)[n()] = static_cast<S>(d);
    }
    return s;
  }
};

}  // namespace test
