// An odometry that never started, although images and gyroscope turn alike.
#pragma once

#include <string>

#include "clock/clock_search.h"
#include "replay/counters.h"

namespace host {

/// A sentence where the filter used no image, the rates of images and gyroscope are the same motion at the offset that
/// stamps were moved by, and the accelerometer shows little but gravity: clocks, R_CI and the gyroscope's axes are
/// right then, and it is the way that is missing, by which a start tells how far everything is. Empty: it started, or
/// the data do not say so.
std::string never_started(const Counters& counters, const ClockSearch& clock, double moved_s, const ImuData& imu);

/// A sentence where the rates of images and gyroscope are the same motion at that offset: what is wrong is neither of
/// these nor R_CI. Empty: the data do not say so.
std::string turns_alike(const ClockSearch& clock, double moved_s);

}  // namespace host
