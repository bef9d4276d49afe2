// An odometry that never started, although images and gyroscope turn alike.
#pragma once

#include <cstdint>
#include <string>

#include "clock/clock_search.h"

namespace host {

/// A sentence where the filter used no image and the rates of images and gyroscope are the same motion at the stated
/// offset: clocks, R_CI and the gyroscope's axes are right then, and it is the way that is missing, by which a start
/// tells how far everything is. Empty: it started, or rotation does not say so.
std::string never_started(std::uint32_t frames_used, std::uint32_t restarts, const ClockSearch& clock, double stated_s);

}  // namespace host
