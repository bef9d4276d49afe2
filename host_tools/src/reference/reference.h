// An independent solution of what the core solves: Ceres, double
// precision, residuals written a second time with automatic derivatives.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "replay/kept_segments.h"

namespace host {

struct ReferenceOptions {
  Calibration calibration;           ///< batch: where it starts, and the mean of the prior
  ImuNoise noise;                    ///< batch
  double pixel_sigma = 0.5;          ///< px; batch
  double keyframe_interval_s = 0.2;  ///< batch
  int threads = 1;
  std::optional<Calibration> start;                  ///< segments: where the iterations start; empty: the prior's mean
  std::function<void(const std::string&)> progress;  ///< one line now and then; may be empty
};

struct ReferenceResult {
  CoreResult result;  ///< as replay has it
  Calibration calibration;
  ImuNoise noise;
  std::vector<CoreState> trajectory;  ///< at each keyframe
};

/// The problem of a replay's last calibration, solved anew.
ReferenceResult reference_segments(const KeptSegments& kept, const ReferenceOptions& options);

/// All keyframes and all tracks of whole recordings; these are sessions that share theta. Throws InputError where the
/// odometry that gives the first states finds no path.
ReferenceResult reference_batch(const std::vector<Recording>& sessions, const ReferenceOptions& options);

/// result.json, camchain-imucam.yaml, imu.yaml, trajectory.tum.
void write_reference_files(const std::filesystem::path& dir, const ReferenceResult& result);

}  // namespace host
