// What `segcal diagnose` says about a session, reduced to what a study compares with the truth.
#pragma once

#include <string>
#include <vector>

#include "calibration_file.h"
#include "experiments/experiment.h"
#include "recording.h"
#include "simulate/effect.h"

namespace host::experiments {

/// {"verdict", "judged", "named": [...], "values": {"effect.parameter": [value, sigma]}, "pairs": [...], "gap_closed",
/// "cannot_tell", "faults": [...], "statistics": {name: s}, "sentence", "seconds"}: of the processor.
Json diagnosed(const Recording& session, const Calibration& start);

/// The truth of a session: {"names": [...], "values": {"effect.parameter": value}}.
Json hidden_truth(const std::vector<sim::EffectTruth>& effects);

/// One answer against its truth.
struct Judged {
  std::vector<std::string> truth, named;   ///< without data faults' sensors; "unlisted" for a term without a name
  bool exact = false;        ///< named what is there, and nothing else
  bool in_pair = false;      ///< not exact, but what is there is what is named or what this motion does not tell from it
  bool false_name = false;   ///< an effect of the catalogue that is not there
  bool in_three_sigma = true;
  double worst_sigmas = 0;
  double gap_closed = 0, seconds = 0;
  bool judged = true, unlisted = false, cannot_tell = false;
  std::string verdict;
};

Judged judged(const CellResult& cell);

}  // namespace host::experiments
