// What is hidden in the recordings of the study `hidden`: which effects, how large, on which motion.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "experiments/experiment.h"
#include "simulate/simulate.h"

namespace host::experiments {

/// Smallest size of an effect in the study: about where 60 s of rich motion give a score statistic of 60.
struct HiddenSize {
  const char* name;
  int values;  ///< a random direction in that many dimensions, scaled to `size` per value (rms)
  double size;
  const char* unit;
  double largest;  ///< factor on `size` of the largest one
};

/// One table for all: sizes of effects of the catalogue that the score test or the variance test is to name.
const std::vector<HiddenSize>& hidden_sizes();

/// Kinds that came later: their cells are behind all others, which so keep their seeds.
const std::vector<HiddenSize>& later_hidden_sizes();

/// An effect that the catalogue has no entry for, from just visible in the excess of chi2 on.
struct HiddenOutside {
  const char* name;
  double size;
  const char* rest;  ///< values behind the first
};
const std::vector<HiddenOutside>& hidden_outside();

/// Pairs of effects that rich motion tells apart; confounded ones (time_offset and gyro_lag) are no fair question.
const std::vector<std::pair<const char*, const char*>>& hidden_pairs();

enum class HiddenGroup { none, one, fault, two, outside, weak };
const char* name_of(HiddenGroup group);
HiddenGroup group_of(const std::string& name);

/// The cells of the study; each has all that it depends on:
/// group, scenario, distortion, seconds, seed, effects as text.
std::vector<Cell> hidden_cases(const StudyOptions& options);

/// The simulated session of a cell.
SimulationResult hidden_session(const Json& parameters);

}  // namespace host::experiments
