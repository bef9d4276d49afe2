#include "diagnose/raw_motion.h"

#include <algorithm>

namespace host::diagnosis {

RawMotion::RawMotion(const std::vector<ImuData>& imu) {
  for (const ImuData& data : imu) {
    has_temperature_ |= data.has_temperature;
    samples_.insert(samples_.end(), data.samples.begin(), data.samples.end());
  }
}

RawMotion::Means RawMotion::over(std::int64_t from, std::int64_t to) const {
  Means out;
  auto first = std::lower_bound(samples_.begin(), samples_.end(), from,
                                [](const ImuSample& s, std::int64_t t) { return s.t_ns < t; });
  if (first == samples_.end()) return out;
  auto last = first;
  int n = 0;
  for (; last != samples_.end() && (n == 0 || last->t_ns <= to); ++last, ++n) {
    out.rate += Eigen::Vector3d(last->gyro[0], last->gyro[1], last->gyro[2]);
    out.force += Eigen::Vector3d(last->accel[0], last->accel[1], last->accel[2]);
    out.temperature += last->temperature_degC;
  }
  --last;
  const double seconds = 1e-9 * static_cast<double>(last->t_ns - first->t_ns);
  for (int i = 0; i < 3 && seconds > 0; ++i) out.rate_change(i) = (last->gyro[i] - first->gyro[i]) / seconds;
  out.rate /= n;
  out.force /= n;
  out.temperature /= n;
  return out;
}

}  // namespace host::diagnosis
