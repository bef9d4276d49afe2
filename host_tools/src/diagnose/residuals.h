// Whitened residuals of a fit with what could have caused them, one list per sensor and axis.
#pragma once

#include "replay/core.h"

namespace host::diagnosis {

/// What a residual is held against. Values at the residual's own moment and place.
enum class Cause {
  time,
  temperature,
  rate_x,
  rate_y,
  rate_z,
  rate_change_x,
  rate_change_y,
  rate_change_z,
  force_x,
  force_y,
  force_z,
  speed,
  image_x,
  image_y,
  radius,
  image_motion_x,
  image_motion_y,
  row_times_rate,
  count
};
constexpr int kCauses = static_cast<int>(Cause::count);
const char* words_of(Cause cause);
const char* unit_of(Cause cause);

/// Residuals of one axis of one sensor: camera u, v, radial; gyro x y z; accel x y z.
struct ResidualList {
  std::string sensor, axis;
  std::vector<double> value;           ///< in units of the stated sigma
  std::vector<double> cause[kCauses];  ///< as long as `value`, or empty: this sensor has no such cause
  std::vector<int> series;             ///< residuals with the same number follow each other in time
};

/// A point's residual with the measured point; the core's getters leave out rejected points in the same order.
struct SeenPoint {
  const CorePoint* point;
  const CorePointResidual* residual;
};
std::vector<SeenPoint> seen_points(const CoreKept& kept);

/// `model`: the noise by which the points' residuals were whitened.
std::vector<ResidualList> residual_lists(const std::vector<CoreKept>& kept, const CoreModel& model,
                                         const Calibration& calibration, const std::vector<ImuData>& imu);

/// Sums of squares by sensor.
struct SensorSquares {
  double camera = 0, gyro = 0, accel = 0;
  int camera_count = 0, gyro_count = 0, accel_count = 0;
};
SensorSquares sensor_squares(const std::vector<CoreKept>& kept);

}  // namespace host::diagnosis
