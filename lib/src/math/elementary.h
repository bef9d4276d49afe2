// sin, cos, tan, atan, atan2, log from + - * / and sqrt only.
// libm differs between platforms in the last bit; these give the same bits wherever IEEE arithmetic is kept
// (no contraction, no reassociation), so that a host can replay a device's log exactly.
// Accuracy: within 2 ulp over the stated ranges, tan and atan2 within 3 (test/math/test_elementary.cpp).
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

/// Largest angle that sin_cos() reduces, rad: a multiple of pi/2 beyond it does not fit into the reduction's integer.
template <class S>
constexpr S kLargestAngle = S(1e9);

/// sin(x) and cos(x); |x| <= 1e4 keeps the stated accuracy (in ulp of 0.01 where the result is below 0.01: the
/// reduction by pi/2 has an absolute error). Not-a-number beyond kLargestAngle.
template <class S>
void sin_cos(S x, S* sine, S* cosine) {
  if (!(absolute(x) <= kLargestAngle<S>)) {
    *sine = *cosine = S(__builtin_nanf(""));
    return;
  }
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
  // Fits (float) and Taylor series (double) on |r| <= pi/4: what they leave out is far below one ulp of each type.
  // The rounding of 1 - r^2/2 is given back.
  S s, c;
  const S halved = S(0.5) * r2, leading = S(1) - halved, lost = (S(1) - leading) - halved;
  // clang-format off
  if constexpr (std::is_same_v<S, float>) {
    s = r + r * (r2 * (-1.6666654611e-1f + r2 * (8.3321608736e-3f + r2 * -1.9515295891e-4f)));
    c = leading + (lost + r2 * r2 * (4.166664568298827e-2f + r2 * (-1.388731625493765e-3f +
        r2 * 2.443315711809948e-5f)));
  } else {
    s = r + r * r2 * (-1.0 / 6 + r2 * (1.0 / 120 + r2 * (-1.0 / 5040 + r2 * (1.0 / 362880 + r2 * (-1.0 / 39916800 +
        r2 * (1.0 / 6227020800.0 - r2 * (1.0 / 1307674368000.0)))))));
    c = leading + (lost + r2 * r2 * (1.0 / 24 + r2 * (-1.0 / 720 + r2 * (1.0 / 40320 + r2 * (-1.0 / 3628800 +
        r2 * (1.0 / 479001600.0 + r2 * (-1.0 / 87178291200.0 + r2 * (1.0 / 20922789888000.0))))))));
  }
  switch (k & 3) {
    case 0: *sine = s; *cosine = c; break;
    case 1: *sine = c; *cosine = -s; break;
    case 2: *sine = -s; *cosine = -c; break;
    default: *sine = -c; *cosine = s; break;
  }
  // clang-format on
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

/// A constant as the sum of two numbers of type S; given as the sum of two doubles.
template <class S>
struct SplitConstant {
  S high, low;
};
template <class S>
constexpr SplitConstant<S> split_constant(double high, double low) {
  return {S(high), S((high - static_cast<double>(S(high))) + low)};
}

/// atan(x), any finite x; rad.
template <class S>
S arc_tangent(S x) {
  const bool negative = x < S(0);
  S a = negative ? -x : x;
  const bool inverted = a > S(1);
  if (inverted) a = S(1) / a;
  // atan(a) = atan(b) + atan((a - b) / (1 + a b)) with b = 0, 1/2 or 1; then |a| <= 0.3.
  SplitConstant<S> base = {S(0), S(0)};
  if (a > S(0.72)) {
    base = split_constant<S>(0.78539816339744830962, 3.0616169978683830e-17);
    a = (a - S(1)) / (a + S(1));
  } else if (a > S(0.3)) {
    base = split_constant<S>(0.46364760900080609352, 2.2698777452961687e-17);
    a = (a - S(0.5)) / (S(1) + S(0.5) * a);
  }
  const S a2 = a * a;
  // Minimax fits of (atan(a) - a) / a^3 (Moshier, Cephes: atanf, atan).
  S rest;
  if constexpr (std::is_same_v<S, float>) {
    rest = -3.33329491539e-1f + a2 * (1.99777106478e-1f + a2 * (-1.38776856032e-1f + a2 * 8.05374449538e-2f));
  } else {
    const S p =
        -6.485021904942025371773e1 +
        a2 * (-1.228866684490136173410e2 +
              a2 * (-7.500855792314704667340e1 + a2 * (-1.615753718733365076637e1 + a2 * -8.750608600031904122785e-1)));
    const S q = 1.945506571482613964425e2 +
                a2 * (4.853903996359136964868e2 +
                      a2 * (4.328810604912902668951e2 +
                            a2 * (1.650270098316988542046e2 + a2 * (2.485846490142306297962e1 + a2))));
    rest = p / q;
  }
  S result = base.high + (base.low + (a + a * (a2 * rest)));
  if (inverted) {
    const SplitConstant<S> quarter = split_constant<S>(1.57079632679489661923, 6.1232339957367660e-17);
    result = quarter.high + (quarter.low - result);
  }
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

/// Natural logarithm of x > 0. Infinity and not-a-number are returned as they are, so that the loops below end: each
/// halves or doubles at most as often as the type has exponents.
template <class S>
S logarithm(S x) {
  if (!is_finite(x)) return x;
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
