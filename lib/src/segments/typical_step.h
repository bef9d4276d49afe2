// Sizes that steps of states and landmarks usually have: damping is measured against them.
#pragma once

#include "segments/segment.h"

namespace SEGCAL_NS {

/// Of a state's column: rad, m, m/s, m/s^2, rad/s.
template <class S>
S typical_step(int state_column) {
  constexpr double size[5] = {0.01, 0.02, 0.05, 0.05, 0.005};
  return S(size[state_column / 3]);
}
/// Of a landmark's direction and inverse distance (1/m).
template <class S>
constexpr S kTypicalLandmarkStep = S(0.02);

}  // namespace SEGCAL_NS
