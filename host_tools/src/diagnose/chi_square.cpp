#include "diagnose/chi_square.h"

#include <cmath>

namespace host::diagnosis {
namespace {

/// x^a e^-x / Gamma(a), as a logarithm.
double log_kernel(double a, double x) { return a * std::log(x) - x - std::lgamma(a); }

/// Lower incomplete gamma function over Gamma(a), by its series; for x < a + 1.
double lower_series(double a, double x) {
  double term = 1 / a, sum = term;
  for (int n = 1; n < 1000 && term > 1e-17 * sum; ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return std::exp(log_kernel(a, x)) * sum;
}

/// Logarithm of the upper one, by Lentz's continued fraction; for x >= a + 1.
double log_upper_fraction(double a, double x) {
  constexpr double tiny = 1e-300;
  double b = x + 1 - a, c = 1 / tiny, d = 1 / b, h = d;
  for (int i = 1; i < 1000; ++i) {
    const double an = -i * (i - a);
    b += 2;
    d = an * d + b;
    d = 1 / (std::abs(d) < tiny ? tiny : d);
    c = b + an / c;
    if (std::abs(c) < tiny) c = tiny;
    const double factor = d * c;
    h *= factor;
    if (std::abs(factor - 1) < 1e-15) break;
  }
  return log_kernel(a, x) + std::log(h);
}

/// Continued fraction of the incomplete beta function (Lentz); converges quickly for x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  const auto kept_off_zero = [](double v) { return std::abs(v) < tiny ? tiny : v; };
  double c = 1, d = 1 / kept_off_zero(1 - (a + b) * x / (a + 1)), h = d;
  for (int m = 1; m < 1000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / kept_off_zero(1 + even * d);
    c = kept_off_zero(1 + even / c);
    h *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / kept_off_zero(1 + odd * d);
    c = kept_off_zero(1 + odd / c);
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return h;
}

/// ln of x^a (1 - x)^b / (a B(a, b)).
double log_beta_kernel(double a, double b, double x) {
  return a * std::log(x) + b * std::log1p(-x) - std::log(a) + std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b);
}

}  // namespace

double log10_upper_tail_of_ratio(double ratio, int m, int n) {
  if (m <= 0 || n <= 0 || !(ratio > 0)) return 0;
  const double a = 0.5 * n, b = 0.5 * m, x = n / (n + m * ratio);
  if (x < (a + 1) / (a + b + 2)) return (log_beta_kernel(a, b, x) + std::log(beta_fraction(a, b, x))) / std::log(10.0);
  return std::log10(1 - std::exp(log_beta_kernel(b, a, 1 - x)) * beta_fraction(b, a, 1 - x));
}

double log10_upper_tail(double s, int dof) {
  if (dof <= 0 || !(s > 0)) return 0;
  const double a = 0.5 * dof, x = 0.5 * s;
  if (x < a + 1) return std::log10(1 - lower_series(a, x));
  return log_upper_fraction(a, x) / std::log(10.0);
}

double upper_quantile(double log10_p, int dof) {
  double low = 0, high = dof + 10;
  while (log10_upper_tail(high, dof) > log10_p) high *= 2;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (log10_upper_tail(middle, dof) > log10_p ? low : high) = middle;
  }
  return high;
}

}  // namespace host::diagnosis
