// The IMU's samples on disk: mav0/imu0/data.csv.
#pragma once

#include <filesystem>

#include "recording.h"

namespace host {

/// Reads the samples of one file; `noise` keeps its defaults. Throws
/// InputError: missing or empty file, wrong column count, non-number.
ImuData read_imu_samples(const std::filesystem::path& file);

}  // namespace host
