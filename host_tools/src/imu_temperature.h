// The temperature column of an IMU: readings that jump away and back, as no die does.
#pragma once

#include "recording.h"

namespace host {

/// of the readings: bridges of so many last far less than a die takes to warm by a kelvin
constexpr double few_temperature_jumps = 0.05;

/// Finds such readings and notes them in ImuData::temperature_jumps. `mend`: where they are few, the good reading
/// before is held in their place; where they are many, so that nobody knows which are the sensor's own, the samples
/// count as without temperature. Coarse steps, noise, and readings that are held for a second or two are as they should
/// be; those that are not a number are the core's business.
void check_temperature(ImuData* imu, bool mend);

/// A sentence; empty where nothing jumps.
std::string temperature_words(const ImuData& imu);

}  // namespace host
