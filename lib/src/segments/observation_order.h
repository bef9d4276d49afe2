// The image points of a segment in the order in which they are used: by landmark, then keyframe, then camera.
#pragma once

#include "segments/segment.h"

namespace SEGCAL_NS {

/// Heap sort: in place, no recursion, the same order everywhere.
template <class S>
[[gnu::cold]] void sort_observations(Segment<S>* s) {
  Observation* o = s->observation;
  const auto key = [](const Observation& z) {
    return (std::uint32_t(z.landmark) << 16) | (std::uint32_t(z.keyframe) << 8) | z.camera;
  };
  const auto sift = [&](int root, int end) {
    for (int child = 2 * root + 1; child < end; child = 2 * root + 1) {
      if (child + 1 < end && key(o[child]) < key(o[child + 1])) ++child;
      if (key(o[root]) >= key(o[child])) return;
      const Observation swap = o[root];
      o[root] = o[child];
      o[child] = swap;
      root = child;
    }
  };
  const int n = s->n_observations;
  for (int i = n / 2 - 1; i >= 0; --i) sift(i, n);
  for (int end = n - 1; end > 0; --end) {
    const Observation swap = o[0];
    o[0] = o[end];
    o[end] = swap;
    sift(0, end);
  }
}

/// first_observation from the sorted list; landmarks with fewer than `fewest` points vanish, the others move up.
template <class S>
void index_observations(Segment<S>* segment, int fewest) {
  Segment<S>& s = *segment;
  int landmarks = 0, kept = 0;
  for (int o = 0; o < s.n_observations;) {
    const int j = s.observation[o].landmark;
    int end = o;
    while (end < s.n_observations && s.observation[end].landmark == j) ++end;
    if (end - o >= fewest && j != kDroppedLandmark) {
      s.track_id[landmarks] = s.track_id[j];
      s.states.landmark[landmarks] = s.states.landmark[j];
      s.first_observation[landmarks] = static_cast<std::uint16_t>(kept);
      for (int i = o; i < end; ++i) {
        s.observation[kept] = s.observation[i];
        s.observation[kept++].landmark = static_cast<ObservationBits>(landmarks);
      }
      ++landmarks;
    }
    o = end;
  }
  s.n_landmarks = landmarks;
  s.n_observations = kept;
  s.first_observation[landmarks] = static_cast<std::uint16_t>(kept);
}

}  // namespace SEGCAL_NS
