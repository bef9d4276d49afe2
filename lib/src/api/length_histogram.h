// Lengths of image residuals, counted in bins, so that their median needs no list.
#pragma once

#include <cstdint>

#include "segcal/config.h"

namespace SEGCAL_NS {

struct LengthHistogram {
  static constexpr int kBins = 400, kBinsPerPixel = 100;  ///< what is beyond counts in the last
  std::int32_t bin[kBins];

  template <class S>
  static int place_of(S length_px) {
    return length_px < S(kBins) / S(kBinsPerPixel) ? static_cast<int>(length_px * S(kBinsPerPixel)) : kBins - 1;
  }
  /// px, of `n` lengths.
  template <class S>
  S median(std::int32_t n) const {
    std::int32_t below = 0;
    int i = 0;
    while (i < kBins - 1 && 2 * (below += bin[i]) < n) ++i;
    return (S(i) + S(0.5)) / S(kBinsPerPixel);
  }
};

}  // namespace SEGCAL_NS
