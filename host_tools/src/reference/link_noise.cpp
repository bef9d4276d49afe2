#include "reference/link_noise.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace host::reference {
namespace {

constexpr double kBinomial[] = {1, -6, 15, -20, 15, -6, 1};
constexpr std::size_t kWeights = std::size(kBinomial);
constexpr double kSquares = 924;  // sum of the binomials' squares
constexpr std::size_t kFewestMeans = 9, kMeans = 48;
constexpr double kScale_s = 0.01, kFastest_s = 1e-5;
constexpr double kByChance = 1.5;  // a short stretch of white noise may look that much larger

using Axis = std::array<double, 3> ImuSample::*;

std::vector<double> means(const std::vector<ImuSample>& samples, std::size_t first, std::size_t last, std::size_t group,
                          Axis sensor, std::size_t axis) {
  std::vector<double> out;
  for (std::size_t i = first; i + group <= last + 1; i += group) {
    double sum = 0;
    for (std::size_t k = 0; k < group; ++k) sum += (samples[i + k].*sensor)[axis];
    out.push_back(sum / static_cast<double>(group));
  }
  return out;
}

double variance(const std::vector<double>& x) {
  double sum = 0;
  for (std::size_t i = 0; i + kWeights <= x.size(); ++i) {
    double difference = 0;
    for (std::size_t k = 0; k < kWeights; ++k) difference += kBinomial[k] * x[i + k];
    sum += difference * difference;
  }
  return sum / (kSquares * static_cast<double>(x.size() - kWeights + 1));
}

/// Of the worst axis, in means of `group`; nothing where there are too few.
std::optional<double> density(double stated, const std::vector<ImuSample>& samples, std::size_t first, std::size_t last,
                              std::size_t group, double interval_s, Axis sensor) {
  double worst = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::vector<double> x = means(samples, first, last, group, sensor, axis);
    if (x.size() < kFewestMeans) return std::nullopt;
    worst = std::max(worst, variance(x));
  }
  const double excess = worst * static_cast<double>(group) * interval_s - kByChance * kByChance * stated * stated;
  return excess > 0 ? std::sqrt(stated * stated + excess) : stated;
}

}  // namespace

LinkNoise link_noise(const CoreModel& stated, const std::vector<ImuSample>& samples, std::int64_t t0_ns,
                     std::int64_t t1_ns) {
  const auto at_or_before = [&samples](std::int64_t t_ns) {
    const auto after = std::upper_bound(samples.begin(), samples.end(), t_ns,
                                        [](std::int64_t t, const ImuSample& s) { return t < s.t_ns; });
    return static_cast<std::size_t>(after - samples.begin()) - 1;
  };
  std::size_t first = at_or_before(t0_ns), last = at_or_before(t1_ns);
  LinkNoise out{stated.gyro_noise_density, stated.accel_noise_density};
  if (last <= first) return out;
  const double interval_s =
      static_cast<double>(samples[last].t_ns - samples[first].t_ns) * 1e-9 / static_cast<double>(last - first);
  if (!(interval_s > kFastest_s)) return out;
  const std::size_t least = interval_s < kScale_s ? static_cast<std::size_t>(std::lround(kScale_s / interval_s)) : 1;
  const std::size_t wanted = kMeans * (least + 1);
  if (wanted > last - first) {
    const std::size_t beside = (wanted - (last - first)) / 2;
    first -= std::min(first, beside);
    last = std::min(samples.size() - 1, last + beside);
  }
  const auto judge = [&](double stated_density, Axis sensor) {
    const double fine =
        density(stated_density, samples, first, last, least, interval_s, sensor).value_or(stated_density);
    return std::min(fine, density(stated_density, samples, first, last, least + 1, interval_s, sensor).value_or(fine));
  };
  out.gyro = judge(out.gyro, &ImuSample::gyro);
  out.accel = judge(out.accel, &ImuSample::accel);
  return out;
}

}  // namespace host::reference
