// The prior on theta: where calibration starts from, and how far
// the factory's values may be off (docs/formats.md, "config.yaml").
#pragma once

#include "math/qr.h"
#include "sensors/calibration.h"
#include "sensors/effect_catalogue.h"

namespace SEGCAL_NS {

template <class S>
struct ThetaPrior {
  Calibration<S> mean;
  S sigma[kMaxTheta] = {};  ///< units of theta's entries
};

/// What may be stated as a sigma, in its own unit; segcal.h says so.
/// Their squares and the squares' inverses stay far inside float.
constexpr double kLeastSigma = 1e-9, kMostSigma = 1e6;

/// The defaults of docs/formats.md, "config.yaml".
template <class S>
[[gnu::cold]] void default_prior_sigmas(const Calibration<S>& mean, S* sigma) {
  const auto put = [&sigma](int n, S value) {
    for (int i = 0; i < n; ++i) *sigma++ = value;
  };
  for (int c = 0; c < mean.n_cameras; ++c) {
    const CameraCalibration<S>& camera = mean.camera[c];
    put(3, S(0.05));
    put(3, S(0.03));
    put(1, S(0.04) * camera.intrinsics(0));
    put(1, S(0.04) * camera.intrinsics(1));
    put(2, S(10));
    if (camera.model == Distortion::fov) {
      put(1, S(0.03));
    } else {
      put(4, camera.model == Distortion::radtan ? S(0.1) : S(0.02));
    }
  }
  put(6, S(0.03));
  put(6, S(0.05));
  put(3, S(0.05));
  for (int i = 0; i < mean.effects.count(); ++i) put(1, S(term_prior_sigma(mean.effects.term[i])));
}

/// A usual step of theta, in the prior's sigmas: damping is measured against it.
template <class S>
constexpr S kTypicalThetaStep = S(0.1);

/// Puts the prior's rows into a triangle over [theta | rhs], with or without candidates between, linearised at theta.
/// With the rows of `damping`, if there is any, folded into them: sigma is smaller, and pulls as before.
template <class S>
void write_prior(const ThetaPrior<S>& prior, const Calibration<S>& theta, PackedTriangle<S>* triangle,
                 S damping = S(0)) {
  const int n = theta.columns();
  S offset[kMaxTheta];
  difference(prior.mean, theta, offset);
  triangle->clear();
  const S damped = damping / kTypicalThetaStep<S>, stiffer = square_root(S(1) + damped * damped);
  for (int i = 0; i < n; ++i) {
    triangle->row(i)[i] = stiffer / prior.sigma[i];
    triangle->row(i)[triangle->columns() - 1] = -offset[i] / (prior.sigma[i] * stiffer);
  }
}

template <class S>
S prior_cost(const ThetaPrior<S>& prior, const Calibration<S>& theta) {
  S offset[kMaxTheta];
  difference(prior.mean, theta, offset);
  S sum = S(0);
  for (int i = 0; i < theta.columns(); ++i) sum += (offset[i] / prior.sigma[i]) * (offset[i] / prior.sigma[i]);
  return sum;
}

}  // namespace SEGCAL_NS
