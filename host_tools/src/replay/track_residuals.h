// The image residuals of a kept segment as tracks: each with the point that was measured.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "replay/core.h"

namespace host {

struct TrackResidual {
  const CorePoint* measured;
  const CorePointResidual* residual;
};

/// Of each landmark and camera, in the order of time. Points that
/// the last calibration left out have no residual and are missing.
std::map<std::pair<int, int>, std::vector<TrackResidual>> tracks_of_segment(const CoreKept& kept);

/// px, predicted minus measured: whitening along the track (white noise and a random walk) undone.
std::vector<Eigen::Vector2d> residuals_px(const std::vector<TrackResidual>& track, const CoreModel& model);
/// Of all tracks of a segment, in the order of `kept.points`.
std::vector<Eigen::Vector2d> residuals_px(const CoreKept& kept, const CoreModel& model);

}  // namespace host
