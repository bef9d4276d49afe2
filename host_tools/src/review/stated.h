// What was stated of the sensors and of gravity, against what the data show.
#pragma once

#include "replay/replay.h"

namespace host::review {

/// White noise of gyroscope and accelerometer, from the raw samples' spectrum (diagnose/imu_noise.h), and of the image
/// points, from differences of residuals of neighbours in the image (diagnose/pixel_noise.h). Said where it is
/// above 1.6 or below 0.5 times what was stated, three sigmas included. Random walks are not judged: a minute's
/// segments do not tell them to a factor of three.
std::vector<Note> notes_on_noise(const Recording& recording, const ReplayResult& result);

/// Gravity's size g, the accelerometer's common scale and all lengths (places, velocities, p_CI) are one direction: f =
/// T_a^-1 (a_m - b) must be a - g, so that T_a times (1 + e) with g, and everything that has a length, over (1 + e)
/// predicts the same images and the same readings. No residual shows a wrong g; what is off is accel.s*, by the share
/// that g is off. Two things can still be said:
///  - all three scales left the start by the same share, more than the prior allows, or by far more than they differ
///  among
///    themselves (t-test, two degrees of freedom): three sensors seldom do that, gravity does;
///  - nobody stated g, and the scales are known so well that 0.03 m/s^2, what a place on Earth is off by, would be seen
///  in them.
std::vector<Note> notes_on_gravity(const CoreOptions& options, const ReplayResult& result);

}  // namespace host::review
