// Noise of the image points, apart from everything that the model could be missing.
#pragma once

#include "diagnose/residuals.h"
#include "replay/replay.h"

namespace host::diagnosis {

/// The noise of the image points alone, over the stated one: half the mean square of the differences between residuals
/// of near neighbours in one image. What is smooth in the image, as all effects are, drops out, and so does the pose.
struct PixelNoise {
  double factor = 1;  ///< of the sigma
  double sigma = 0;   ///< of the factor
  int pairs = 0;
};
PixelNoise pixel_noise(const std::vector<CoreKept>& kept);

/// Corners that follow their own error for many images: held against white noise, every small misfit that lasts is
/// significant, and no name stands beside it. What is missing in the model moves along a track as well, but neighbours
/// alike; each track drifts by itself, so that the differences of neighbours must hold the squares. `neighbours`:
/// pixel_noise of the same fit, of white noise.
bool each_track_drifts(const ReplayResult& fit, const PixelNoise& neighbours);

}  // namespace host::diagnosis
