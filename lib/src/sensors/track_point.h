// One tracked image point, as the filter and the segments take it.
#pragma once

#include "math/types.h"

namespace SEGCAL_NS {

/// Raw (distorted) pixels. The same id is the same corner, in all frames and cameras.
template <class S>
struct TrackPoint {
  std::uint32_t id;
  std::int32_t camera;
  Vec2<S> uv;  ///< px
};

}  // namespace SEGCAL_NS
