// One inertial link of the start: what the samples say about the motion from the window's first frame to another one.
#pragma once

#include "math/types.h"

namespace SEGCAL_NS {

/// Motion from the first frame to one frame, in the first frame's axes, with its change by constant biases.
template <class S>
struct StartLink {
  S t;             ///< s
  Mat3<S> dR;      ///< R_{I0 Ii}
  Vec3<S> dv, dp;  ///< without gravity; m/s, m
  Mat3<S> R_bg;    ///< right perturbation of dR by b_g
  Mat<S, 3, 3> v_ba, v_bg, p_ba, p_bg;
  Mat3<S> dR_base;  ///< as integrated
  Vec3<S> dv_base, dp_base;
};

}  // namespace SEGCAL_NS
