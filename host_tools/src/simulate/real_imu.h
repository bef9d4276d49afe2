// Real IMU samples for a simulation whose camera alone is simulated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "../recording.h"

namespace host::sim {

/// Samples of an imu.csv (timestamp [ns], w_xyz [rad/s], a_xyz [m/s^2]) with stamps in [from_ns, to_ns].
/// Throws InputError for a malformed file, or if the samples do not reach both ends.
std::vector<ImuSample> read_imu_samples(const std::filesystem::path& file, std::int64_t from_ns, std::int64_t to_ns);

}  // namespace host::sim
