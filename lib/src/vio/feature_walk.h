// The rows of one feature where corners walk: whitened as a segment's are (segments/track_noise.h).
//
// The walk counts from the first point that the feature has: points that were used before are another feature, whose
// landmark took up what the corner had walked by then.
#pragma once

#include "segments/track_noise.h"
#include "vio/vio_triangulate.h"

namespace SEGCAL_NS {

/// Columns [first, last) of rows that two each point has, one after the other, in units of the white noise. `walk` is
/// the random walk's variance in these units, 1/s.
template <class S>
void whiten_walk(Window<S>* w, const TrackView<S>& view, S walk, int first, int last) {
  constexpr int kStrip = 8;
  S gain[kWindow], scale[kWindow];
  S known = S(0);  // variance of the walk given the points so far
  for (int i = 0; i < view.n; ++i) {
    const std::int64_t since_ns = i ? w->pose[view.pose[i]].time - w->pose[view.pose[i - 1]].time : 0;
    const S before = known + walk * (S(since_ns) * S(1e-9));
    known = gain[i] = before / (before + S(1));
    scale[i] = S(1) / square_root(before + S(1));
  }
  for (int strip = first; strip < last; strip += kStrip) {
    const int columns = last - strip < kStrip ? last - strip : kStrip;
    S d[2][kStrip] = {};
    for (int i = 0; i < 2 * view.n; ++i) {
      S* const row = w->block + i * kBlockStride + strip;
      S* const at = d[i % 2];
      for (int c = 0; c < columns; ++c) {
        const S innovation = row[c] - at[c];
        row[c] = scale[i / 2] * innovation;
        at[c] += gain[i / 2] * innovation;
      }
    }
  }
}

}  // namespace SEGCAL_NS
