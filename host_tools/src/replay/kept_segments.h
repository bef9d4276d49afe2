// kept_segments.json: all that a calibration was made from, so that another solver can repeat it (docs/formats.md).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "replay/replay.h"

namespace host {

/// The problem that a calibration solved.
struct KeptSegments {
  CoreModel model;
  Calibration start;                ///< mean of the prior
  std::vector<double> prior_sigma;  ///< per parameter, in the order of parameter_names()
  ImuNoise noise;
  /// variance that the segments' disagreement put into the sigmas; 1: no more than their residuals did
  double scatter = 1;
  /// parameters of effects that the calibration estimated as well; none is in `start`
  std::vector<std::string> effects;
  int condensed = 0;  ///< further segments that took part as epochs: of these nothing is left to repeat it from
  std::vector<CoreKept> segments;  ///< in the order of the calibration
};

/// The segments that took part in the last calibration of a replay.
KeptSegments kept_segments(const ReplayResult& result);

std::string kept_segments_json(const KeptSegments& kept);
/// Reads DIR/kept_segments.json. Throws InputError if it is missing, of another format or incomplete.
KeptSegments read_kept_segments(const std::filesystem::path& dir);

}  // namespace host
