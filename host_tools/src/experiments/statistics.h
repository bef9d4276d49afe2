// Small sums over lists.
#pragma once

#include <cmath>
#include <vector>

#include "quantile.h"

namespace host::experiments {

inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

inline double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? std::nan("") : sum / static_cast<double>(values.size());
}

inline double deviation(const std::vector<double>& values) {
  if (values.size() < 2) return std::nan("");
  const double m = mean(values);
  double sum = 0;
  for (const double v : values) sum += (v - m) * (v - m);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

/// Geometric mean: the middle of ratios.
inline double geometric_mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += std::log(v);
  return values.empty() ? std::nan("") : std::exp(sum / static_cast<double>(values.size()));
}

/// The median of a[i] / b[i]: both over the same sessions, so that what a session is like cancels.
inline double median_ratio(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) ratios.push_back(a[i] / b[i]);
  return median(ratios);
}

}  // namespace host::experiments
