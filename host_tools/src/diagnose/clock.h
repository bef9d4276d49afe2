// The camera's clock against the IMU's, over time: from image rotation and gyroscope, without a map.
#pragma once

#include <vector>

#include "calibration_file.h"
#include "diagnose/gyro_path.h"
#include "diagnose/image_rotation.h"

namespace host {

/// Offset t_imu - t_cam in one window.
struct OffsetInWindow {
  double t = 0;                  ///< middle of the window, s since the first IMU sample
  double offset = 0, sigma = 0;  ///< s
};

struct ClockDrift {
  double slope = 0, sigma = 0;  ///< s/s
  double offset = 0;            ///< s, in the middle of the recording
  double change = 0;            ///< s, from the first to the last frame
  double log10_p = 0;           ///< of how often clocks that keep step show such a slope
};

/// Offset per window of ten seconds, each with its own gyroscope bias and camera rotation, so that errors of these are
/// not taken for time. Windows whose motion does not tell (sigma above 20 ms) are left out.
std::vector<OffsetInWindow> offsets_over_time(const std::vector<FramePair>& pairs, const GyroPath& gyro,
                                              const Eigen::Matrix3d& R_CI, double start_offset);

/// A line through the offsets, weighted. The slope's sigma is for what windows usually scatter by and for how badly the
/// line fits, by degrees of freedom. All zero for fewer than three windows.
ClockDrift drift_of(const std::vector<OffsetInWindow>& offsets);

}  // namespace host
