// The sessions of a day of stream (soak.cpp).
#pragma once

#include <cstdint>

#include "simulate/simulate.h"

namespace host::experiments {

/// Half the sessions are shaken, half held as a headset is; half of either, those of an odd `index`, have faults. The
/// device depends on `seed` alone.
SimulationResult soak_session(std::uint64_t seed, int index, double seconds);

}  // namespace host::experiments
