// White noise of an IMU link as its own samples show it.
#pragma once

#include "recording.h"
#include "replay/core.h"

namespace host::reference {

/// rad/s/sqrt(Hz) and m/s^2/sqrt(Hz).
struct LinkNoise {
  double gyro = 0, accel = 0;
};

/// From the sixth differences of means over 10 ms, and of one sample more, whichever says less; of the worst axis; of
/// the samples from the last one at or before t0 to the last one at or before t1, and of others around them up to 48 of
/// the longer means (docs/design.md, section 4). Up to 1.5 times what was stated it is what was stated; beyond that the
/// excess is added. Fewer than nine means: as stated.
LinkNoise link_noise(const CoreModel& stated, const std::vector<ImuSample>& samples, std::int64_t t0_ns,
                     std::int64_t t1_ns);

}  // namespace host::reference
