// sin, cos, atan, atan2, acos, exp, log from + - * / and sqrt only.
// libm differs between platforms in the last bit; these give the same bits wherever IEEE arithmetic is kept
// (no contraction, no reassociation), so that a host can replay a device's log exactly.
// Accuracy: within 2 ulp of float and 4 ulp of double over the stated ranges (test/math/test_elementary.cpp).
#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "math/types.h"

namespace SEGCAL_NS {

template <class S>
inline S square_root(S x) {
  if constexpr (std::is_same_v<S, float>) {
    return __builtin_sqrtf(x);
  } else {
    return __builtin_sqrt(x);
  }
}

template <class S>
inline S absolute(S x) {
  return x < S(0) ? -x : x;
}

template <class S>
inline bool is_finite(S x) {
  return x - x == S(0);
}

template <class S>
constexpr S pi = S(3.14159265358979323846264338327950288L);

/// sin(x) and cos(x); |x| <= 1e4 keeps the stated accuracy.
template <class S>
void sin_cos(S x, S* sine, S* cosine) {
  // x = k pi/2 + r, |r| <= pi/4, with pi/2 split in two parts (Cody and Waite).
  const S scaled = x * S(0.636619772367581343075535L);
  const std::int32_t k = static_cast<std::int32_t>(scaled + (scaled < S(0) ? S(-0.5) : S(0.5)));
  const S n = static_cast<S>(k);
  S r;
  if constexpr (std::is_same_v<S, float>) {
    r = ((x - n * 1.5703125f) - n * 4.837512969970703125e-4f) - n * 7.54978995489188216e-8f;
  } else {
    r = ((x - n * 1.57079632673412561417e+00) - n * 6.07710050630396597660e-11) - n * 2.02226624879595063154e-21;
  }
  const S r2 = r * r;
  // Taylor series on |r| <= pi/4: the first term left out is below one ulp of each type.
  S s, c;
  if constexpr (std::is_same_v<S, float>) {
    s = r + r * r2 * (-1.6666654611e-1f + r2 * (8.3321608736e-3f + r2 * -1.9515295891e-4f));
    c = 1.0f - 0.5f * r2 + r2 * r2 * (4.166664568298827e-2f + r2 * (-1.388731625493765e-3f + r2 * 2.443315711809948e-5f));
  } else {
    s = r + r * r2 * (-1.0 / 6 + r2 * (1.0 / 120 + r2 * (-1.0 / 5040 + r2 * (1.0 / 362880 + r2 * (-1.0 / 39916800 +
        r2 * (1.0 / 6227020800.0 - r2 * (1.0 / 1307674368000.0)))))));
    c = 1.0 - 0.5 * r2 + r2 * r2 * (1.0 / 24 + r2 * (-1.0 / 720 + r2 * (1.0 / 40320 + r2 * (-1.0 / 3628800 +
        r2 * (1.0 / 479001600.0 + r2 * (-1.0 / 87178291200.0 + r2 * (1.0 / 20922789888000.0)))))));
  }
  switch (k & 3) {
    case 0: *sine = s; *cosine = c; break;
    case 1: *sine = c; *cosine = -s; break;
    case 2: *sine = -s; *cosine = -c; break;
    default: *sine = -c; *cosine = s; break;
  }
}

template <class S>
S sine(S x) {
  S s, c;
  sin_cos(x, &s, &c);
  return s;
}

template <class S>
S cosine(S x) {
  S s, c;
  sin_cos(x, &s, &c);
  return c;
}

template <class S>
S tangent(S x) {
  S s, c;
  sin_cos(x, &s, &c);
  return s / c;
}

/// atan(x), any finite x; rad.
template <class S>
S arc_tangent(S x) {
  const bool negative = x < S(0);
  S a = negative ? -x : x;
  const bool inverted = a > S(1);
  if (inverted) a = S(1) / a;
  // Halve the angle twice: atan(a) = 2 atan(a / (1 + sqrt(1 + a^2))); then |a| <= tan(pi/16) and the series is short.
  S factor = S(1);
  for (int i = 0; i < 2; ++i) {
    a = a / (S(1) + square_root(S(1) + a * a));
    factor = factor * S(2);
  }
  const S a2 = a * a;
  constexpr int terms = std::is_same_v<S, float> ? 6 : 13;
  S sum = S(0);
  for (int i = terms; i >= 1; --i) {
    const S coefficient = S((i & 1) ? -1 : 1) / S(2 * i + 1);
    sum = a2 * (coefficient + sum);
  }
  S result = factor * (a + a * sum);
  if (inverted) result = pi<S> / S(2) - result;
  return negative ? -result : result;
}

/// atan2(y, x) in (-pi, pi]; rad. atan2(0, 0) = 0.
template <class S>
S arc_tangent2(S y, S x) {
  if (x == S(0) && y == S(0)) return S(0);
  if (absolute(x) >= absolute(y)) {
    const S a = arc_tangent(y / x);
    if (x > S(0)) return a;
    return y < S(0) ? a - pi<S> : a + pi<S>;
  }
  const S a = arc_tangent(x / y);
  return y > S(0) ? pi<S> / S(2) - a : -pi<S> / S(2) - a;
}

/// Natural logarithm of a positive normal number.
template <class S>
S logarithm(S x) {
  // x = m 2^e with m in [sqrt(1/2), sqrt(2)): log x = e log 2 + 2 atanh((m - 1) / (m + 1)).
  int e = 0;
  while (x >= S(1.41421356237309504880L)) {
    x = x * S(0.5);
    ++e;
  }
  while (x < S(0.70710678118654752440L) && x > S(0)) {
    x = x * S(2);
    --e;
  }
  const S f = (x - S(1)) / (x + S(1));
  const S f2 = f * f;
  constexpr int terms = std::is_same_v<S, float> ? 5 : 11;
  S sum = S(0);
  for (int i = terms; i >= 1; --i) sum = f2 * (S(1) / S(2 * i + 1) + sum);
  return S(e) * S(0.693147180559945309417232L) + S(2) * (f + f * sum);
}

}  // namespace SEGCAL_NS
