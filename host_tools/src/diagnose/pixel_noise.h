// Noise of the image points, apart from everything that the model could be missing.
#pragma once

#include "diagnose/residuals.h"

namespace host::diagnosis {

/// The noise of the image points alone, over the stated one: half the mean square of the differences between residuals of
/// near neighbours in one image. What is smooth in the image, as all effects are, drops out, and so does the pose.
struct PixelNoise {
  double factor = 1;             ///< of the sigma
  double sigma = 0;              ///< of the factor
  int pairs = 0;
};
PixelNoise pixel_noise(const std::vector<CoreKept>& kept);

}  // namespace host::diagnosis
