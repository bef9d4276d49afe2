// Stamps taken in a callback, put back to the moments at which an evenly clocked sensor measured.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace host {

struct SmoothedStamps {
  std::vector<std::int64_t> t_ns;  ///< one for each event, increasing
  double period_s = 0;             ///< median interval
  double moved_rms_s = 0, moved_most_s = 0;
  std::size_t missing = 0;  ///< events that the even clock made and the log does not hold
};

/// Local linear regression (Cleveland, "Robust locally weighted regression and smoothing scatterplots", JASA 1979):
/// each stamp is replaced by the value at its own event of a robust line through the stamps of one second before and
/// after it over the event's number. A sensor's clock is even over two seconds, also where automatic exposure changes a
/// camera's rate over longer times; a callback's delay is not. Events are numbered by their count; one is missing where
/// all later stamps are a period late, since a late callback delays its own stamp only. The mean delay stays in: it is
/// part of the time offset. Stamps that do not increase are no callback's: they come back as they are.
SmoothedStamps smooth_stamps(const std::vector<std::int64_t>& t_ns);

}  // namespace host
