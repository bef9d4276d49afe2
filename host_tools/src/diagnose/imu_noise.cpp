#include "diagnose/imu_noise.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "diagnose/rest.h"
#include "diagnose/spectrum.h"
#include "quantile.h"

namespace host {
namespace {

constexpr std::size_t least_windows = 16;  // of 128 samples, half of each shared: 5 s at 200 Hz
constexpr double most_unsteady = 2.0;      // upper over lower quartile of window levels (power): white noise gives 1.4
constexpr double shortest_rest_s = 8;
constexpr double allan_from_s = 0.1, allan_to_s = 0.5;

using Axis = std::vector<double>;

std::array<Axis, 6> columns(const std::vector<ImuSample>& samples) {
  std::array<Axis, 6> out;
  for (const ImuSample& s : samples) {
    for (std::size_t i = 0; i < 3; ++i) {
      out[i].push_back(s.gyro[i]);
      out[3 + i].push_back(s.accel[i]);
    }
  }
  return out;
}

/// Levels of one axis' windows: power in the noise band and below it, in units of density^2.
struct Levels {
  std::vector<double> noise, lower, upper, motion;  ///< lower and upper: halves of the noise band
};

/// Windows of the least power below the band. They are chosen by other frequencies than those that are measured, so
/// that the choice does not favour low noise.
std::vector<double> quiet_quarter(const Levels& levels) {
  std::vector<std::size_t> order(levels.noise.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return levels.motion[a] < levels.motion[b]; });
  order.resize(std::max<std::size_t>(order.size() / 4, least_windows / 2));
  std::vector<double> out;
  for (std::size_t i : order) out.push_back(levels.noise[i]);
  return out;
}

/// Medians over the quarter of the windows with the most power below the band: noise, and its two halves.
std::array<double, 3> of_lively_quarter(const Levels& levels) {
  const double limit = quantile(levels.motion, 0.75);
  std::vector<double> of[3];
  for (std::size_t i = 0; i < levels.motion.size(); ++i) {
    if (levels.motion[i] < limit) continue;
    of[0].push_back(levels.noise[i]);
    of[1].push_back(levels.lower[i]);
    of[2].push_back(levels.upper[i]);
  }
  return {quantile(of[0], 0.5), quantile(of[1], 0.5), quantile(of[2], 0.5)};
}

AxisNoise axis_noise(const Levels& levels, double* unsteady) {
  const std::vector<double> quiet = quiet_quarter(levels);
  AxisNoise axis;
  const double power = quantile(quiet, 0.5), spread = quantile(quiet, 0.75) / quantile(quiet, 0.25);
  axis.density = std::sqrt(power);
  axis.median_density = std::sqrt(quantile(levels.noise, 0.5));
  // Normal: the quartiles are 1.35 deviations apart; the median
  // of n scatters by 1.25 / sqrt(n), windows overlap by half.
  axis.sigma = 0.5 * axis.density * std::log(spread) / 1.35 * 1.25 * std::sqrt(1.5 / static_cast<double>(quiet.size()));
  *unsteady = std::max(*unsteady, spread);
  return axis;
}

std::string sentence(const SensorNoise& noise, const char* sensor) {
  char text[360];
  const char* const end =
      noise.verdict == SensorNoise::Verdict::above       ? "more noise than stated: state it, or look for vibration"
      : noise.verdict == SensorNoise::Verdict::below     ? "less than stated: stated on purpose, or the sensor filters"
      : noise.verdict == SensorNoise::Verdict::as_stated ? "as stated"
                                                         : "motion fills the band: no more than this";
  std::snprintf(text, sizeof text, "%s noise %.2f +- %.2f times the stated density (%.2e): %s", sensor, noise.factor,
                noise.sigma, noise.stated, end);
  std::string out = text;
  if (noise.grows) {
    std::snprintf(
        text, sizeof text,
        "; %.1f times where it shakes most, alike at all frequencies: it grows with motion, as vibration does",
        noise.lively_factor);
    out += text;
  }
  return out;
}

/// Noise that only the spectrum shows and rest does not is vibration of something else than the sensor.
double allan_factor(const SensorNoise& noise) {
  double squares = 0;
  for (const AxisNoise& axis : noise.axes) squares += axis.allan_density * axis.allan_density / 3;
  return std::sqrt(squares) / noise.stated;
}

void judge(SensorNoise& noise, const char* sensor) {
  using V = SensorNoise::Verdict;
  const double high = noise.factor - 3 * noise.sigma, low = noise.factor + 3 * noise.sigma;
  const bool rest_disagrees = !noise.allan.empty() && allan_factor(noise) < noise_factor_high;
  if (high > noise_factor_high) {
    noise.verdict = noise.steady && !rest_disagrees ? V::above : V::cannot_tell;
  } else {
    noise.verdict = low < noise_factor_low ? V::below : V::as_stated;
  }
  noise.words = sentence(noise, sensor);
}

SensorNoise sensor_noise(const Axis* axes, const Span& rest, double rate_hz, double stated, const char* sensor) {
  SensorNoise noise;
  noise.stated = stated;
  double unsteady = 0, squares = 0, variance = 0;
  std::array<double, 3> lively{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Levels levels{band_levels(axes[i], rate_hz, noise_band), band_levels(axes[i], rate_hz, lower_noise_band),
                        band_levels(axes[i], rate_hz, upper_noise_band), band_levels(axes[i], rate_hz, motion_band)};
    if (levels.noise.size() < least_windows) {
      noise.words = std::string(sensor) + " noise: too few samples to tell";
      return noise;
    }
    noise.axes[i] = axis_noise(levels, &unsteady);
    squares += noise.axes[i].density * noise.axes[i].density / 3;
    const std::array<double, 3> most = of_lively_quarter(levels);
    for (std::size_t k = 0; k < 3; ++k) lively[k] += most[k] / 3;
    variance += noise.axes[i].sigma * noise.axes[i].sigma / 9;
  }
  noise.factor = std::sqrt(squares) / stated;
  noise.sigma = std::sqrt(variance) / stated;
  noise.steady = unsteady < most_unsteady;
  noise.lively_factor = std::sqrt(lively[0]) / stated;
  noise.grows =
      noise.lively_factor > noise_factor_high * std::max(1.0, noise.factor) && lively[2] > least_whiteness * lively[1];
  noise.allan = allan_deviation(axes, rest, rate_hz);
  for (std::size_t i = 0; i < 3; ++i)
    noise.axes[i].allan_density = white_density(noise.allan, i, allan_from_s, allan_to_s);
  judge(noise, sensor);
  return noise;
}

}  // namespace

RawNoise raw_imu_noise(const Recording& recording) {
  const std::vector<ImuSample> samples = samples_with_frames(recording);
  const double rate_hz = median_rate_hz(samples);
  RawNoise out;
  if (!(rate_hz > 0)) return out;
  const std::array<Axis, 6> axes = columns(samples);
  Span rest = longest_rest(axes, rate_hz);
  out.rest_s = static_cast<double>(rest.end - rest.begin) / rate_hz;
  if (out.rest_s < shortest_rest_s) rest = {0, 0};
  out.gyro = sensor_noise(&axes[0], rest, rate_hz, recording.imu.noise.gyro_noise_density, "gyroscope");
  out.accel = sensor_noise(&axes[3], rest, rate_hz, recording.imu.noise.accel_noise_density, "accelerometer");
  return out;
}

}  // namespace host
