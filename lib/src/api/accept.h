// The one way in for numbers of the C API: converted first, and tested as what the core will compute with. A double can
// be beyond float's range, or be zero once it is a float.
#pragma once

#include "math/elementary.h"

namespace SEGCAL_NS {

/// The value in the core's type; false, and nothing stored, unless
/// it is in [least, most], which must be numbers of that type.
template <class S>
bool accept(double value, double least, double most, S* out) {
  if (!(value >= least && value <= most)) return false;  // not-a-number too
  *out = static_cast<S>(value);
  return true;
}

/// The same for n numbers.
template <class S>
bool accept(const double* value, int n, double least, double most, S* out) {
  for (int i = 0; i < n; ++i) {
    if (!accept(value[i], least, most, &out[i])) return false;
  }
  return true;
}

/// A positive number from [least, most], or the default where it is 0.
template <class S>
bool accept_or_default(double value, double fallback, double least, double most, S* out) {
  return accept(value == 0 ? fallback : value, least, most, out);
}

}  // namespace SEGCAL_NS
