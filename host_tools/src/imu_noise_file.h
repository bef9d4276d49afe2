// The IMU's noise figures on disk: EuRoC's imu0/sensor.yaml or Kalibr's imu.yaml.
#pragma once

#include <filesystem>

#include "recording.h"

namespace host {

/// Reads the noise of a recording from the first of mav0/imu0/sensor.yaml, imu.yaml and dso/imu_config.yaml (TUM-VI's
/// place) that exists. Throws InputError if none does, or if a figure is missing or not positive.
ImuNoise read_recording_noise(const std::filesystem::path& recording_root);

/// Reads one file in either naming. Throws InputError.
ImuNoise read_noise_file(const std::filesystem::path& file);

}  // namespace host
