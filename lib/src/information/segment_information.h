// What a segment says about theta: the square root of its information (docs/design.md, sections 5 and 6).
#pragma once

#include "math/qr.h"
#include "sensors/calibration.h"

namespace SEGCAL_NS {

/// R_theta (upper triangle), d_theta as its last column and rho as the last diagonal entry:
/// min over all else of the segment's cost = |R_theta delta - d_theta|^2 + rho^2.
template <class S>
struct SegmentInformation {
  std::int32_t n_theta = 0;
  std::int32_t dof = 0;  ///< residuals minus states and landmarks, theta not counted
  S data[packed_size(kMaxTheta + 1)];

  PackedTriangle<S> triangle() { return PackedTriangle<S>(data, n_theta + 1); }
  /// Entry (i, j) of R_theta, j >= i.
  S R(int i, int j) const { return data[i * (n_theta + 1) - i * (i - 1) / 2 - i + j]; }
  S d(int i) const { return R(i, n_theta); }
  S rho2() const { return R(n_theta, n_theta) * R(n_theta, n_theta); }
};

}  // namespace SEGCAL_NS
