// What faults do to a recording in memory; their sizes are in
// fault_kinds.cpp. Places are shares of the recording's samples.
#pragma once

#include <cstdint>

#include "recording.h"

namespace host::sim::spoil {

ImuSample& sample(Recording& r, double place);

/// Stamps from the middle on, s.
void jump_imu(Recording& r, double seconds);
void jump_camera(Recording& r, double seconds);

/// Every n-th sample and the one before change places in the log.
void swap_samples(Recording& r, std::size_t n);
void duplicate(Recording& r, std::size_t every_sample, std::size_t every_frame);

void lose_imu(Recording& r, double place, double seconds);
void lose_bursts(Recording& r, double every_s, double seconds);
void drop_samples(Recording& r, double share, std::uint64_t seed);
void drop_frames(Recording& r, double share, std::uint64_t seed);
/// From the middle on.
void halve_imu_rate(Recording& r);
void halve_camera_rate(Recording& r);

/// A random axis of the accelerometer in a share of the samples, m/s^2.
void spikes(Recording& r, double share, double value, std::uint64_t seed);
/// Readings as 16-bit numbers over +-2000 deg/s and +-16 g, one
/// bit of one axis of which is wrong in a `share` of the samples.
void flip_bits(Recording& r, double share, std::uint64_t seed);
/// The gyroscope clips at a share of its largest reading. `known`: clipped readings are at full scale (35 rad/s), as of
/// a sensor whose range the configuration states.
void saturate(Recording& r, double share, bool known);
void freeze_accel_z(Recording& r);

/// A share of the tracks: each image anywhere, or running off at `drift` px/s where that is not 0.
void outliers(Recording& r, double share, double drift, std::uint64_t seed);
void permute_ids(Recording& r, std::size_t every_frame, std::uint64_t seed);
void reuse_ids(Recording& r, std::uint32_t modulus);
void renumber_from_middle(Recording& r);
/// No corners, in the middle.
void cover(Recording& r, double seconds);
void scale_pixels(Recording& r, double factor);
/// From the middle on, px.
void move_pixels(Recording& r, double du, double dv);

}  // namespace host::sim::spoil
