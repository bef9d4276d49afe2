// Sigmas of single parameters, whatever the others are.
#pragma once

#include "information/release_rules.h"
#include "math/qr.h"
#include "math/small_solvers.h"

namespace SEGCAL_NS {

/// Sigma of the combination sum_k weight[k] theta[first + k] from the triangle R: the length of R^-T a.
template <class S>
S marginal_sigma(const PackedTriangle<S>& R, int n, int first, const S* weight, int count, S* work) {
  for (int r = first; r < n; ++r) work[r] = r < first + count ? weight[r - first] : S(0);
  forward_substitute(R, n, first, work);
  return square_root(factor_product(work + first, work + first, n - first));
}

/// Whether half of n entries are known. `T`: of prior and data, in units of the prior's sigmas. `work`: n numbers.
template <class S>
bool knows_half(const PackedTriangle<S>& T, int n, S* work) {
  const S one = S(1);
  int known = 0;
  for (int i = 0; i < n; ++i) known += marginal_sigma(T, n, i, &one, 1, work) < ReleaseRules<S>{}.observed ? 1 : 0;
  return 2 * known >= n;
}

}  // namespace SEGCAL_NS
