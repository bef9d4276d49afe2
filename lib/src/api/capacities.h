// The capacities that a program and the library must share: both have their layouts from config.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "segcal/segcal.h"

namespace SEGCAL_NS {

constexpr std::uint32_t kCapacities[SEGCAL_N_CAPACITIES] = SEGCAL_CAPACITIES;

/// SEGCAL_MAX_EFFECT_COLUMNS: of questions that are answered at once, and of nothing that is stored.
constexpr int kEffectColumnsCapacity = 15;

/// Index of the first that differs; SEGCAL_N_CAPACITIES if none does.
inline int first_difference(const std::uint32_t* capacities) {
  int i = 0;
  while (i < SEGCAL_N_CAPACITIES && capacities[i] == kCapacities[i]) ++i;
  return i;
}

}  // namespace SEGCAL_NS
