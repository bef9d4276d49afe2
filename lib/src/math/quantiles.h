// Upper quantiles of the normal and the F distribution, for tests.
#pragma once

#include "math/elementary.h"

namespace SEGCAL_NS {

/// The z that a standard normal number exceeds with probability p, 0 < p <= 0.5, to 5e-4 (Abramowitz and
/// Stegun, 26.2.23).
template <class S>
S normal_upper_quantile(S p) {
  const S t = square_root(S(-2) * logarithm(p));
  return t - (S(2.515517) + t * (S(0.802853) + t * S(0.010328))) /
                 (S(1) + t * (S(1.432788) + t * (S(0.189269) + t * S(0.001308))));
}

/// What the ratio of two mean squares with m and n degrees of freedom exceeds with probability p (Paulson: the cube
/// roots of mean squares are nearly normal, with variance 2/9m and mean 1 - 2/9m). Zero if n is too small for a limit;
/// within 2 % from ten degrees on.
template <class S>
S f_upper_quantile(int m, int n, S p) {
  const S va = S(2) / (S(9) * S(m)), vb = S(2) / (S(9) * S(n)), a = S(1) - va, b = S(1) - vb;
  const S z = normal_upper_quantile(p), d = b * b - z * z * vb;
  if (!(d > S(0))) return S(0);
  // (b y - a)^2 = z^2 (va + vb y^2) for the cube root y.
  const S y = (a * b + square_root(a * a * b * b - d * (a * a - z * z * va))) / d;
  return y * y * y;
}

/// Upper 1 % point of chi-square (Wilson and Hilferty).
template <class S>
S chi_square_gate(int dof) {
  const S k = S(2) / (S(9) * S(dof));
  const S root = S(1) - k + S(2.326) * square_root(k);
  return S(dof) * root * root * root;
}

}  // namespace SEGCAL_NS
