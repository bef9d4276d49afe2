// A recording's twin: the same motion, corners and sensors in simulation, without what a diagnosis found and with it.
// Does the simulation look like the measurement then? What a name explains must not only make residuals smaller: put
// into a simulator that was written apart from the fit, it must bring about what was measured.
//
// The motion is that of the fit (motion.h). The landmarks are those of the fit's segments, in the world of the
// odometry, so that depths and places in the image are the recording's; corners live as long as the recording's do.
// `plain` has the stated noise and no effect; `with_effects` has the effects by name and the noise that samples and
// tracks show. Terms without a name have no model in the simulator: they are left out, and said so.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnose/diagnose.h"
#include "simulate/simulate.h"

namespace host::twin {

/// One figure of the measurement, and of the two simulations.
struct Statistic {
  std::string name, unit;
  double measured = 0, sigma = 0;  ///< sigma: what chance does to it; 0: not known
  double plain = 0, with_effects = 0;

  /// Is the plain simulation another one than the measurement, by more than chance?
  bool differs() const;
  /// Share of that difference that is left with the effects.
  double left() const;
  double left_sigma() const;
};

struct Comparison {
  std::string why_not;                     ///< no twin could be made; a sentence; empty: there is one
  std::vector<std::string> effects;        ///< as `segcal simulate --effect` takes them, and the corners' noise
  std::vector<std::string> not_simulated;  ///< names or words of what the simulator has no model of
  std::vector<Statistic> statistics;
  std::string said_of_plain, said_of_twin;  ///< what diagnosis says of the two simulations
  double seconds = 0, recorded_s = 0;       ///< of the twin's motion; of the recording that the measured figures are of
  std::optional<SimulationResult> twin;     ///< with effects; empty: there is none
};

/// `options`: those of the diagnosis `found` of `session` alone.
Comparison compare_with_twin(const Recording& session, const Diagnosis& found, const DiagnoseOptions& options);

}  // namespace host::twin
