#include "diagnose/rest.h"

#include <algorithm>
#include <cmath>

#include "quantile.h"

namespace host {
namespace {

constexpr double block_s = 0.5;
constexpr double steady_rate = 0.003;  // rad/s
constexpr double steady_force = 0.03;  // m/s^2

double mean_of(const std::vector<double>& x, std::size_t begin, std::size_t n) {
  double sum = 0;
  for (std::size_t k = begin; k < begin + n; ++k) sum += x[k];
  return sum / static_cast<double>(n);
}

/// Root mean square of second differences of block means, blocks of m samples, every start.
double allan_at(const std::vector<double>& x, const Span& span, std::size_t m) {
  std::vector<double> sums(1, 0);
  for (std::size_t k = span.begin; k < span.end; ++k) sums.push_back(sums.back() + x[k]);
  double squares = 0;
  std::size_t n = 0;
  for (std::size_t k = 0; k + 2 * m < sums.size(); ++k, ++n) {
    const double step = (sums[k + 2 * m] - 2 * sums[k + m] + sums[k]) / static_cast<double>(m);
    squares += step * step;
  }
  return n ? std::sqrt(squares / (2 * static_cast<double>(n))) : 0;
}

}  // namespace

std::vector<ImuSample> samples_with_frames(const Recording& recording) {
  std::int64_t first = INT64_MAX, last = INT64_MIN;
  for (const CameraData& camera : recording.cameras) {
    for (const Frame& frame : camera.frames) {
      first = std::min(first, frame.t_ns);
      last = std::max(last, frame.t_ns);
    }
  }
  if (first > last) return recording.imu.samples;
  std::vector<ImuSample> out;
  for (const ImuSample& s : recording.imu.samples)
    if (s.t_ns >= first && s.t_ns <= last) out.push_back(s);
  return out;
}

double median_rate_hz(const std::vector<ImuSample>& samples) {
  if (samples.size() < 3) return 0;
  std::vector<double> steps;
  for (std::size_t k = 1; k < samples.size(); ++k)
    steps.push_back(static_cast<double>(samples[k].t_ns - samples[k - 1].t_ns));
  const double step = quantile(std::move(steps), 0.5);
  return step > 0 ? 1e9 / step : 0;
}

Span longest_rest(const std::array<std::vector<double>, 6>& axes, double rate_hz) {
  const auto n = static_cast<std::size_t>(block_s * rate_hz);
  Span longest, now;
  if (n == 0) return longest;
  std::array<double, 6> first{};
  for (std::size_t begin = 0; begin + n <= axes[0].size(); begin += n) {
    bool same = now.end == begin && now.end > now.begin;
    std::array<double, 6> means{};
    for (std::size_t i = 0; i < 6; ++i) {
      means[i] = mean_of(axes[i], begin, n);
      same = same && std::abs(means[i] - first[i]) < (i < 3 ? steady_rate : steady_force);
    }
    if (!same) {
      now.begin = begin;
      first = means;
    }
    now.end = begin + n;
    if (now.end - now.begin > longest.end - longest.begin) longest = now;
  }
  return longest;
}

std::vector<AllanPoint> allan_deviation(const std::vector<double>* axes, const Span& span, double rate_hz) {
  std::vector<AllanPoint> out;
  std::size_t last = 0;
  for (double tau = 2 / rate_hz; tau * rate_hz * 9 <= static_cast<double>(span.end - span.begin); tau *= 1.5) {
    const auto m = static_cast<std::size_t>(std::lround(tau * rate_hz));
    if (m == last) continue;
    last = m;
    AllanPoint point{static_cast<double>(m) / rate_hz, {}};
    for (std::size_t i = 0; i < 3; ++i) point.deviation[i] = allan_at(axes[i], span, m);
    out.push_back(point);
  }
  return out;
}

double white_density(const std::vector<AllanPoint>& points, std::size_t axis, double from_s, double to_s) {
  std::vector<double> densities;
  for (const AllanPoint& p : points)
    if (p.tau_s >= from_s && p.tau_s <= to_s) densities.push_back(p.deviation[axis] * std::sqrt(p.tau_s));
  return densities.empty() ? 0 : quantile(std::move(densities), 0.5);
}

}  // namespace host
