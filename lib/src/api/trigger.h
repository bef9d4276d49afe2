// When to calibrate: not at a count of segments, but when what they tell together is enough.
#pragma once

#include "api/release.h"
#include "information/joint_information.h"

namespace SEGCAL_NS {

template <class S>
bool has_targets(const S* target_sigma, int n) {
  for (int i = 0; i < n; ++i) {
    if (target_sigma[i] > S(0)) return true;
  }
  return false;
}

/// True if every predicted sigma is at its target (0: none). `T`: the triangle of prior and segments in units of the
/// prior's sigmas. With `everything`, when no place is left to learn more in, nobody waits for what the segments hardly
/// show: it would not be released with any value.
template <class S>
bool reaches_targets(const PackedTriangle<S>& T, const S* prior_sigma, const S* target_sigma, bool everything) {
  const int n = T.columns();
  S work[kMaxTheta];
  for (int i = 0; i < n; ++i) {
    if (!(target_sigma[i] > S(0))) continue;
    const S one = S(1), relative = marginal_sigma(T, n, i, &one, 1, work);
    if (relative * prior_sigma[i] <= target_sigma[i]) continue;
    if (!everything || relative < ReleaseRules<S>{}.weak) return false;
  }
  return true;
}

}  // namespace SEGCAL_NS
