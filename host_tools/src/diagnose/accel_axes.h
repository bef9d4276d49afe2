// The accelerometer against the gyroscope: whether its axes are the ones that they are said to be.
#pragma once

#include <vector>

#include "diagnose/fault.h"
#include "diagnose/gyro_path.h"

namespace host {

/// Adds fault axes.accel if another order of the accelerometer's axes is clearly better. The gyroscope's rates are to
/// be read as M (rate - bias); `bias` need not be better than a tenth of a rad/s.
void accel_axes_fault(const Recording& recording, const GyroPath& gyro, const Eigen::Vector3d& bias,
                      const Eigen::Matrix3d& M, std::vector<Fault>* out);

}  // namespace host
