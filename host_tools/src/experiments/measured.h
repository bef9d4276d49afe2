// What the cells of the study `measured` do: one calibration
// each, of data between simulation and reality, as a user would.
#pragma once

#include <filesystem>

#include "calibration_file.h"
#include "experiments/experiment.h"

namespace host::experiments {

/// Rendered images of a drawn device, the real tracker: {scenario, seconds, rate_hz, seed, line_delay_s}.
Json calibrate_rendered(const Json& parameters);

/// Landmarks simulated along a recorded path, with that recording's IMU
/// samples or simulated ones: {sequence, data, seconds, seed, real_imu}.
Json calibrate_imu_gt(const Json& parameters);

/// A real recording tracked with the start under test: {data, start, factor}, start 0 to 10 in directions of their own,
/// `factor` times 2 % in f, 10 px in c, 1.7 deg and 27 mm off what is published.
Json calibrate_euroc(const Json& parameters);

}  // namespace host::experiments
