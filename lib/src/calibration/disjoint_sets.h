// Union-find over the segments of a calibration: which of them share one gauge.
#pragma once

#include <cstdint>

#include "segcal/config.h"

namespace SEGCAL_NS {

constexpr int kMaxSegments = SEGCAL_MAX_SEGMENTS;

/// A set's root is its first segment. Paths are halved as they are walked, so that they stay short without recursion.
class DisjointSets {
 public:
  void reset(int n) {
    for (int i = 0; i < n; ++i) parent_[i] = static_cast<std::int16_t>(i);
  }
  int root(int i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }
  bool same(int a, int b) { return root(a) == root(b); }
  /// False if the two are in one set already.
  bool join(int a, int b) {
    a = root(a);
    b = root(b);
    if (a == b) return false;
    parent_[a > b ? a : b] = static_cast<std::int16_t>(a < b ? a : b);
    return true;
  }

 private:
  std::int16_t parent_[kMaxSegments];
};

}  // namespace SEGCAL_NS
