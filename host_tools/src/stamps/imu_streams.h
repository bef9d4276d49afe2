// An IMU whose gyroscope and accelerometer were logged as two streams of events, as phones do.
#pragma once

#include <filesystem>

#include "recording.h"

namespace host {

/// Reads FOLDER/gyro.csv and FOLDER/accel.csv (`timestamp [ns], x, y, z`) into samples at the
/// gyroscope's stamps; the specific force is interpolated linearly between the accelerometer's
/// events, and samples outside its span are left out. `smooth`: both streams' stamps are
/// smoothed first (smooth_stamps.h), and `notes` says by how much. Throws InputError.
std::vector<ImuSample> read_imu_streams(const std::filesystem::path& folder, bool smooth,
                                        std::vector<std::string>* notes);

/// The sentence that `notes` gets: what smoothing did to a stream.
std::string smoothing_note(const std::string& stream, std::size_t events, double period_s, double rms_s, double most_s,
                           std::size_t missing);

}  // namespace host
