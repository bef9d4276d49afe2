// What a device log's first two blocks say about the device: its capacities and its configuration.
#pragma once

#include <cstdint>
#include <string>

#include "calibration_file.h"
#include "segcal/segcal.h"

namespace host {

/// Numbers of the header that tell a profile, from the size of a number on. The last two are not in the headers of
/// older writers, which are taken to be as the profile is.
constexpr int kLoggedCapacities = 19, kFewestLoggedCapacities = 17;
/// Name of the profile with these capacities, of which the log has the first n; empty: it is none of ours.
std::string profile_of(const std::uint32_t* capacities, int n);

Calibration calibration_of(const segcal_config_t& config);

/// Zero is the default there as here.
ImuNoise noise_of(const segcal_config_t& config);

}  // namespace host
