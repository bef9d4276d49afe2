#include "imu_data_file.h"

#include "csv.h"

namespace host {
namespace {

constexpr const char* imu_columns =
    "timestamp [ns], w_x, w_y, w_z [rad/s], a_x, a_y, a_z [m/s^2] (, temperature [degC])";

}  // namespace

ImuData read_imu_samples(const std::filesystem::path& file) {
  ImuData imu;
  CsvReader csv(file, imu_columns, 7, 8);
  while (csv.next_row()) {
    ImuSample sample;
    sample.t_ns = csv.stamp(0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sample.gyro[axis] = csv.number(1 + axis);
      sample.accel[axis] = csv.number(4 + axis);
    }
    imu.has_temperature = csv.columns() == 8;
    if (imu.has_temperature) sample.temperature_degC = csv.number(7);
    imu.samples.push_back(sample);
  }
  return imu;
}

}  // namespace host
