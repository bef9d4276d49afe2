#include "real_imu.h"

#include "../csv.h"

namespace host::sim {
namespace {

constexpr std::int64_t largest_miss_ns = 20000000;

}  // namespace

std::vector<ImuSample> read_imu_samples(const std::filesystem::path& file, std::int64_t from_ns, std::int64_t to_ns) {
  std::vector<ImuSample> samples;
  CsvReader csv(file, "timestamp [ns], w_x, w_y, w_z [rad/s], a_x, a_y, a_z [m/s^2]", 7, 8);
  while (csv.next_row()) {
    ImuSample sample;
    sample.t_ns = csv.integer(0);
    if (sample.t_ns < from_ns || sample.t_ns > to_ns) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sample.gyro[axis] = csv.number(1 + axis);
      sample.accel[axis] = csv.number(4 + axis);
    }
    samples.push_back(sample);
  }
  const bool complete = !samples.empty() && samples.front().t_ns - from_ns < largest_miss_ns &&
                        to_ns - samples.back().t_ns < largest_miss_ns;
  if (!complete)
    csv.fail("samples over the whole time of the trajectory, " + std::to_string(from_ns) + " to " +
             std::to_string(to_ns) + " ns");
  return samples;
}

}  // namespace host::sim
