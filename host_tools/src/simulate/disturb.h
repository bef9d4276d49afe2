// Faults and hidden effects put into a finished recording, simulated or real: what electronics, drivers and loggers do.
// Sample values and stamps only; the ground truth stays.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "../recording.h"

namespace host::disturb {

enum class Sensor { gyro, accel };

/// Readings beyond +-limit of their axis stay at the limit; rad/s, m/s^2. 0: that sensor is left alone.
void clip(Recording& recording, double gyro_limit, double accel_limit);

/// Takes out every n-th IMU sample, from the n-th on.
void drop_imu_samples(Recording& recording, int every_n);

/// Adds normal errors to the stamps, s per standard deviation;
/// stamps stay in order (at least 1 us apart), values as they were.
void jitter_stamps(Recording& recording, double imu_sigma_s, double camera_sigma_s, std::uint64_t seed);

/// From `t_ns` on a sensor repeats its last reading for `seconds`.
void freeze(Recording& recording, Sensor sensor, std::int64_t t_ns, double seconds);

/// Readings times a factor from `t_ns` on, per axis: wrong units, or a scale that changes.
void scale(Recording& recording, Sensor sensor, const Eigen::Vector3d& factor, std::int64_t t_ns = INT64_MIN);

/// Readings plus an offset from `t_ns` on, rad/s or m/s^2: a sensor that was trimmed anew.
void offset(Recording& recording, Sensor sensor, const Eigen::Vector3d& by, std::int64_t t_ns);

/// Readings of the axes in another order or with another sign: "x-yz" keeps all but y's sign, "yxz" swaps x and y.
/// Throws InputError for anything that is not each axis once.
void reorder_axes(Recording& recording, Sensor sensor, const std::string& axes);

/// Camera stamps += shift_s, and += drift times the time since the first frame (a clock of its own that runs off).
void shift_camera_stamps(Recording& recording, double shift_s, double drift = 0);

/// Gyroscope += T_gs accelerometer; rad s/m.
void add_g_sensitivity(Recording& recording, const Eigen::Matrix3d& T_gs);

/// Stamp in the middle between the first and the last IMU sample.
std::int64_t middle_ns(const Recording& recording);

}  // namespace host::disturb
