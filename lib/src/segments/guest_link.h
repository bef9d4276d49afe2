// How a segment hangs on the one before it: the guest is that one's last keyframe.
#pragma once

#include "segments/reduced_system.h"

namespace SEGCAL_NS {

/// What joins a segment to the one before it in time.
enum class Join : std::int32_t {
  none,  ///< starts a partition: gauge and bias prior on its first keyframe
  imu,   ///< follows directly: the raw samples between the two are integrated
  bias   ///< gap: only the bias random walk links them
};

template <class S>
struct GuestLink {
  Join join = Join::none;
  State<S> state;  ///< the previous segment's last keyframe
  S gap_s = S(0);  ///< s from there to the first keyframe (Join::bias)
  /// position and rotation about gravity come from ties: no gauge is held (calibration/partitions.h)
  bool hangs = false;
  TiedLandmarks tied;
  KeptLinks<S, kMaxKeyframes>* kept = nullptr;  ///< integrals of the segment's links, while a fit is under way

  bool holds_gauge() const { return join != Join::imu && !hangs; }
};

}  // namespace SEGCAL_NS
