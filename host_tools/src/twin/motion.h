// The motion of a recording, as its fit tells it: poses of the odometry at the images, and between them what the
// IMU's samples say of the way from one to the next.
#pragma once

#include "replay/replay.h"
#include "simulate/trajectory_fit.h"

namespace host::twin {

/// Poses at the IMU's samples (200 Hz at most) over the longest stretch in which the odometry neither stops nor jumps;
/// empty where there is none of three seconds. Gyroscope and accelerometer are integrated from the first pose on, and
/// what is then missing to the poses of the images is added as a curve that is smooth over half a second: fast motion
/// is the samples', slow motion the odometry's, and its small jumps at each image are nobody's.
sim::PoseSeries motion_of(const Recording& session, const ReplayResult& fit);

}  // namespace host::twin
