// Whole numbers of JSON files. nlohmann's get<int>() casts any number, and a cast of 1e300 to an integer is undefined.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "recording.h"

namespace host {

/// Throws InputError, without a file name, where `json` is no whole number or does not fit.
template <class Whole, class Json>
Whole whole_number(const Json& json) {
  const bool fits =
      json.is_number_unsigned()
          ? json.template get<std::uint64_t>() <= static_cast<std::uint64_t>(std::numeric_limits<Whole>::max())
          : json.is_number_integer() && (std::numeric_limits<Whole>::is_signed
                                             ? json.template get<std::int64_t>() >=
                                                       static_cast<std::int64_t>(std::numeric_limits<Whole>::min()) &&
                                                   json.template get<std::int64_t>() <=
                                                       static_cast<std::int64_t>(std::numeric_limits<Whole>::max())
                                             : json.template get<std::int64_t>() >= 0);
  if (!fits)
    throw InputError("expected a whole number below " + std::to_string(std::numeric_limits<Whole>::max()) + ", found " +
                     json.dump().substr(0, 40));
  return json.template get<Whole>();
}

}  // namespace host
