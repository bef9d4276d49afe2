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

/// Sigma over the prior's from which on an entry counts as known.
template <class S>
constexpr S kKnown = S(0.3);

/// Whether half of n entries are known. `T`: of prior and data, in units of the prior's sigmas. `work`: n numbers.
template <class S>
bool knows_half(const PackedTriangle<S>& T, int n, S* work) {
  const S one = S(1);
  int known = 0;
  for (int i = 0; i < n; ++i) known += marginal_sigma(T, n, i, &one, 1, work) < kKnown<S> ? 1 : 0;
  return 2 * known >= n;
}

}  // namespace SEGCAL_NS
