#include "effect.h"

namespace host::sim {

void Effect::on_imu(double, const Trajectory&, ImuReading&) const {}

double Effect::exposure_time(const CameraCalibration&, double t_stamp, double) const { return t_stamp; }

void Effect::on_pixel(const CameraCalibration&, double, Eigen::Vector2d&) const {}

}  // namespace host::sim
