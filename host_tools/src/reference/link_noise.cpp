#include "reference/link_noise.h"

#include <algorithm>
#include <cmath>

namespace host::reference {
namespace {

constexpr double kBinomial[] = {1, -6, 15, -20, 15, -6, 1};
constexpr std::size_t kWeights = std::size(kBinomial);
constexpr double kSquares = 924;             // sum of the binomials' squares
constexpr std::size_t kFewest = 9;
constexpr double kByChance = 1.5;            // a short stretch of white noise may look that much larger

/// Mean square over the three axes, `reading` being the array of one sensor.
double white_variance(const ImuSample* first, std::size_t n, const std::array<double, 3> ImuSample::*reading) {
  double sum = 0;
  for (std::size_t i = 0; i + kWeights <= n; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double difference = 0;
      for (std::size_t k = 0; k < kWeights; ++k) difference += kBinomial[k] * (first[i + k].*reading)[axis];
      sum += difference * difference;
    }
  }
  return sum / (3 * kSquares * static_cast<double>(n - kWeights + 1));
}

double density(double stated, double variance, double interval_s) {
  const double excess = variance * interval_s - kByChance * kByChance * stated * stated;
  return excess > 0 ? std::sqrt(stated * stated + excess) : stated;
}

}  // namespace

LinkNoise link_noise(const CoreModel& stated, const std::vector<ImuSample>& samples, std::int64_t t0_ns, std::int64_t t1_ns) {
  const auto after = [&samples](std::int64_t t_ns) {
    return std::upper_bound(samples.begin(), samples.end(), t_ns, [](std::int64_t t, const ImuSample& s) { return t < s.t_ns; });
  };
  LinkNoise out{stated.gyro_noise_density, stated.accel_noise_density};
  const auto first = after(t0_ns) - 1, end = after(t1_ns);
  const auto n = static_cast<std::size_t>(end - first);
  if (n < kFewest) return out;
  const double interval_s = static_cast<double>((end - 1)->t_ns - first->t_ns) * 1e-9 / static_cast<double>(n - 1);
  out.gyro = density(out.gyro, white_variance(&*first, n, &ImuSample::gyro), interval_s);
  out.accel = density(out.accel, white_variance(&*first, n, &ImuSample::accel), interval_s);
  return out;
}

}  // namespace host::reference
