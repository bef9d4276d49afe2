// Sigmas of single parameters, whatever the others are.
#pragma once

#include "math/qr.h"

namespace SEGCAL_NS {

/// Sigma of the combination sum_k weight[k] theta[first + k] from the triangle R: the length of R^-T a.
template <class S>
S marginal_sigma(const PackedTriangle<S>& R, int n, int first, const S* weight, int count, S* work) {
  S sum2 = S(0);
  for (int r = first; r < n; ++r) {
    S sum = r < first + count ? weight[r - first] : S(0);
    for (int c = first; c < r; ++c) sum -= R(c, r) * work[c];
    work[r] = R(r, r) == S(0) ? S(0) : sum / R(r, r);
    sum2 += work[r] * work[r];
  }
  return square_root(sum2);
}

}  // namespace SEGCAL_NS
