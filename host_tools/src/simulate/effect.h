// Departures of the real sensors from the calibrated model. The simulator calls each hook in one place.
#pragma once

#include <Eigen/Core>

#include "../calibration_file.h"
#include "trajectory.h"

namespace host::sim {

/// One reading of the IMU: rad/s in the gyroscope's axes, m/s^2 in the accelerometer's.
struct ImuReading {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();
};

/// An effect overrides the hooks that it needs; what is not overridden changes nothing. Effects must not keep state
/// between calls that depends on the order of cameras; IMU hooks come in order of time.
class Effect {
 public:
  virtual ~Effect() = default;

  /// Changes a reading after scale, misalignment and rotation, before bias and noise. `t` in s since the first frame.
  virtual void on_imu(double t, const Trajectory& truth, ImuReading& reading) const;

  /// Time on the IMU's clock, s, at which the image row `v_row`, px, of the frame stamped `t_stamp`, s, was exposed.
  /// Several effects are applied one after another.
  virtual double exposure_time(const CameraCalibration& camera, double t_stamp, double v_row) const;

  /// Moves an ideal pixel to where the real lens puts it.
  virtual void on_pixel(const CameraCalibration& camera, double t, Eigen::Vector2d& pixel) const;
};

}  // namespace host::sim
