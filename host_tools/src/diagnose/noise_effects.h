// Noise above the stated one, as an effect with a name: a factor
// on the sigma of the raw samples or of the image points.
#pragma once

#include <array>
#include <optional>

#include "diagnose/diagnose.h"
#include "diagnose/gap.h"
#include "diagnose/imu_noise.h"
#include "diagnose/pixel_noise.h"

namespace host::diagnosis {

/// A variance component: the excess of the mean square over the stated one, without the factor, and on each half of the
/// samples with the factor of the other half.
struct NoiseEffect {
  DiagnosedEffect effect;
  SensorShares before, after;
};
/// `halves`: the factor of each parameter's two halves; 0: not known, nothing counts as closed.
NoiseEffect noise_effect(const std::string& name, const std::vector<DiagnosedParameter>& factors,
                         const std::vector<std::array<double, 2>>& halves);
/// From the raw samples, where their noise is above the stated one; the densities in `noise` grow by the factors.
std::optional<NoiseEffect> imu_noise_effect(const Recording& recording, const RawNoise& raw, ImuNoise* noise);
/// Of the image points at a fit. `segments`: its kept ones in the
/// order of time; `ratio`: the fit's pixel sigma over the stated one.
NoiseEffect pixel_noise_effect(const PixelNoise& noise, const std::vector<CoreKept>& segments, double ratio);

/// Variances of camera, gyroscope and accelerometer as measured apart from the fit, over those that the fit's `weights`
/// say. Not below the stated noise: what stays within it is no disagreement. `known`: of the image points, what a fit
/// with larger weights has of the stated variance; `stated`: of the IMU, with factors that were found.
std::array<Floor, 3> noise_floors(double known, const PixelNoise& pixels, const RawNoise& raw, const CoreModel& weights,
                                  const ImuNoise& stated);

/// Adds them to the gap and to the named effects.
void add_noise_gap(const std::vector<NoiseEffect>& noise, Diagnosis* out);

}  // namespace host::diagnosis
