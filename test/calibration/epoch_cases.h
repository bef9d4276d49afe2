// What tests of epochs share: a device, and an epoch's triangle as a matrix.
#pragma once

#include <Eigen/LU>

#include "../support/cases.h"
#include "../support/synthetic_segments.h"
#include "calibration/epochs.h"

namespace test {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

inline Matrix square(const SEGCAL_NS::PackedTriangle<double>& T, int n) {
  Matrix R = Matrix::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    for (int c = i; c < n; ++c) R(i, c) = T(i, c);
  }
  return R;
}

inline SyntheticOptions device(std::uint32_t seed) {
  SyntheticOptions options;
  options.seed = seed;
  options.segments = 4;
  options.keyframes = 12;
  options.landmarks = 40;
  return options;
}

/// With the prior, as covariance.
inline Matrix covariance(const SEGCAL_NS::Epoch<double>& epoch, const SEGCAL_NS::ThetaPrior<double>& prior) {
  const int n = epoch.columns();
  const Matrix R = square(SEGCAL_NS::PackedTriangle<double>(const_cast<double*>(epoch.information.data), n + 1), n);
  const Vector sigma = Eigen::Map<const Vector>(prior.sigma, n);
  const Matrix H = R.transpose() * R + Matrix(sigma.cwiseAbs2().cwiseInverse().asDiagonal());
  return H.inverse();
}

}  // namespace test
