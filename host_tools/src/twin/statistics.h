// Figures of a diagnosis that a twin is compared by.
#pragma once

#include "twin/twin.h"

namespace host::twin {

/// Of `found`: residuals of the corners with the plain model, how they go on along tracks, each sensor's excess over
/// its noise, the noise of the samples, and what residuals follow most. The other two are left at zero.
std::vector<Statistic> statistics_of(const Diagnosis& found);

/// The same figures of another diagnosis, in the same order.
std::vector<double> same_of(const std::vector<Statistic>& statistics, const Recording& session, const Diagnosis& other);

}  // namespace host::twin
