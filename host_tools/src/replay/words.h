// Directions of the calibration space in words: "gyro.sz + 0.3 accel.mx: not excited".
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "replay/core.h"

namespace host {

/// The parameters that make up a direction, largest first; weights below `least` of the largest are left out.
std::vector<std::pair<std::string, double>> main_weights(const CoreDirection& direction,
                                                         const std::vector<std::string>& names, double least = 0.2);
std::string in_words(const CoreDirection& direction, const std::vector<std::string>& names);

/// Names of theta's entries for a calibration, in order (docs/formats.md, "result.json"); without terms of effects.
std::vector<std::string> parameter_names(const Calibration& calibration);
/// The same of a result, with the terms of effects that were estimated.
std::vector<std::string> parameter_names(const CoreResult& result, const Calibration& calibration);

/// The surest one of what changed, and up to two more beyond four sigmas: "cam0.fx by 0.31 +- 0.02 px, ...". `per`:
/// behind each unit.
struct Surest {
  std::string words;
  bool sure = false;  ///< beyond four sigmas
};
Surest surest_of(const std::vector<double>& values, const std::vector<double>& sigmas, const CoreResult& result,
                 const std::string& per);

/// "the device changed between session 1 and 2: cam0.r_CI.x by 0.0087 +- 0.0004 rad, ...": the three surest steps.
std::string change_words(const CoreChange& change, const CoreResult& result);

/// "over 8 sessions the calibration changes with temperature: cam0.fx by 0.031 +- 0.002 px per degC, ..."; empty where
/// nothing but the dated changes is to be said.
std::string course_words(const CoreResult& result);

/// Of the newest change, which is open; and the course that the calibration before it found.
std::string open_change_words(const CoreResult& result);

}  // namespace host
