// What a segment or an epoch says about theta, near another theta than the one where it was linearised.
#pragma once

#include "information/segment_information.h"
#include "sensors/calibration.h"

namespace SEGCAL_NS {

/// Row i of [R | d - R offset], 0 <= i <= n: what `rows` say about theta [-] (theta_0 [+] offset). Row n is what they
/// leave over themselves.
template <class S>
[[gnu::cold]] void moved_row(const SegmentInformation<S>& rows, const S* offset, int i, S* row) {
  const int n = rows.n_theta;
  for (int c = 0; c <= n; ++c) row[c] = c < i ? S(0) : rows.R(i, c);
  for (int c = i; c < n; ++c) row[n] -= row[c] * offset[c];
}

/// Folds the first `count` of them into a triangle.
template <class S>
[[gnu::cold]] void fold_moved_rows(const SegmentInformation<S>& rows, const S* offset, int count,
                                   PackedTriangle<S>* T) {
  const int n = rows.n_theta;
  S row[kMaxTheta + 1];
  for (int i = 0; i < count; ++i) {
    moved_row(rows, offset, i, row);
    fold_rows(*T, row, 1, n + 1, i, n + 1);
  }
}

/// Folds rows over theta into a triangle, moved from where they are linearised; without what they leave over
/// themselves.
template <class S>
[[gnu::cold]] void fold_moved(const SegmentInformation<S>& rows, const Calibration<S>& from, const Calibration<S>& to,
                              PackedTriangle<S>* T) {
  S offset[kMaxTheta];
  difference(from, to, offset);
  fold_moved_rows(rows, offset, rows.n_theta, T);
}

}  // namespace SEGCAL_NS
