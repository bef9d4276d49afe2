// Effects of temperature are worth no more than the readings that they follow.
#pragma once

#include "replay/replay.h"

namespace host {

/// Whether a parameter is a coefficient of temperature: "gyro_temperature.x", or a term such as "accel_z:T".
bool is_of_temperature(const std::string& parameter);

/// Takes `calibrated` back where an effect of temperature was estimated
/// and the readings of a session are not to be used (imu_temperature.h).
void refuse_temperature(const std::vector<Recording>& sessions, ReplayResult* result);

}  // namespace host
