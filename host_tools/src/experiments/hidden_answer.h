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

/// An effect is visible where its score statistic at the fit without effects, chi-square
/// where it is not there, is at least this: the smallest sizes of the study have about
/// that in 60 s of rich motion. Below it a name may be missing, but none may be wrong.
constexpr double kVisibleStatistic = 60;

/// One answer against its truth.
struct Judged {
  std::vector<std::string> truth, named;  ///< without data faults' sensors; "unlisted" for a term without a name
  bool exact = false;                     ///< named what is there, and nothing else
  bool in_pair = false;     ///< not exact, but what is there is what is named or what this motion does not tell from it
  bool false_name = false;  ///< an effect of the catalogue that is not there
  bool in_three_sigma = true;
  double worst_sigmas = 0;
  /// the least of the score statistics of what is there; NaN where nothing has one (steps, noises, no effect)
  double statistic = 0;
  bool visible = true;  ///< the statistic is at least kVisibleStatistic, or NaN
  double gap_closed = 0, seconds = 0;
  bool judged = true, unlisted = false, cannot_tell = false;
  std::string verdict;
};

Judged judged(const CellResult& cell);

}  // namespace host::experiments
