#include "diagnose/spectrum.h"

#include <algorithm>
#include <cmath>

#include "angles.h"
#include "quantile.h"

namespace host {
namespace {

constexpr std::size_t window_size = 128;
constexpr double median_of_exponential = 0.693147180559945;

std::vector<double> taper() {
  std::vector<double> w(window_size);
  for (std::size_t k = 0; k < window_size; ++k) {
    const double a = two_pi * (static_cast<double>(k) + 0.5) / window_size;
    w[k] = 0.35875 - 0.48829 * std::cos(a) + 0.14128 * std::cos(2 * a) - 0.01168 * std::cos(3 * a);
  }
  return w;
}

/// |sum of x exp(-i a k)|^2 by Goertzel's recursion.
double power_at(const std::vector<double>& x, double angle) {
  const double c = 2 * std::cos(angle);
  double s1 = 0, s2 = 0;
  for (double v : x) {
    const double s0 = v + c * s1 - s2;
    s2 = s1;
    s1 = s0;
  }
  return s1 * s1 + s2 * s2 - c * s1 * s2;
}

}  // namespace

std::vector<double> band_levels(const std::vector<double>& signal, double rate_hz, const Band& band) {
  static const std::vector<double> w = taper();
  double norm = 0;
  for (double v : w) norm += v * v;
  std::vector<double> levels, x(window_size), powers;
  for (std::size_t begin = 0; begin + window_size <= signal.size(); begin += window_size / 2) {
    double mean = 0;
    for (std::size_t k = 0; k < window_size; ++k) mean += signal[begin + k] / window_size;
    for (std::size_t k = 0; k < window_size; ++k) x[k] = w[k] * (signal[begin + k] - mean);
    powers.clear();
    for (auto bin = static_cast<std::size_t>(std::ceil(band.from * window_size));
         static_cast<double>(bin) <= band.to * window_size; ++bin)
      powers.push_back(power_at(x, two_pi * static_cast<double>(bin) / window_size));
    // A sample of density N has the variance N^2 rate; its power
    // at a bin is exponentially distributed about that times norm.
    const double level = quantile(powers, 0.5) / (median_of_exponential * norm * rate_hz);
    if (std::isfinite(level)) levels.push_back(level);
  }
  return levels;
}

}  // namespace host
