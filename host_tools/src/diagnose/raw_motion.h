// How the device moved around a moment: means of its IMU's raw samples.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "recording.h"

namespace host::diagnosis {

class RawMotion {
 public:
  /// `imu`: one for each session, in order of time.
  explicit RawMotion(const std::vector<ImuData>& imu);

  bool has_temperature() const { return has_temperature_; }

  struct Means {
    Eigen::Vector3d rate{0, 0, 0}, rate_change{0, 0, 0}, force{0, 0, 0};  ///< rad/s, rad/s^2, m/s^2
    double temperature = 0;                                               ///< degC
  };
  /// Over [from, to] ns, at least one sample; zero behind the last one.
  Means over(std::int64_t from, std::int64_t to) const;

 private:
  std::vector<ImuSample> samples_;
  bool has_temperature_ = false;
};

}  // namespace host::diagnosis
