#include "experiments/registry.h"

namespace host::experiments {

const std::vector<Experiment>& experiments() {
  static const std::vector<Experiment> all = {
      {"accuracy", "odometry RMSE with the calibration of each method (paper, table II)", false, accuracy_cells,
       accuracy_run, accuracy_gather},
      {"repeatability", "calibrations of one device from several sessions: mean and scatter (table III)", false,
       repeatability_cells, repeatability_run, repeatability_gather},
      {"sessions", "database kept over sessions against one that starts anew each session (figure 7)", false,
       sessions_cells, sessions_run, sessions_gather},
      {"database_size", "how many segments are enough: 1 to 15 (figure 9)", false, database_size_cells,
       database_size_run, database_size_gather},
      {"runtime", "time per image, per segment and per calibration on this machine (table IV)", true, runtime_cells,
       runtime_run, runtime_gather},
      {"basin", "starts that are 1, 2, 3 and 5 sigmas off: does the calibration converge?", false, basin_cells,
       basin_run, basin_gather},
      {"degenerate", "line, rotation in place, planar motion, rest: nothing false is released", false, degenerate_cells,
       degenerate_run, degenerate_gather},
      {"sigma_ref", "typical sigma of each parameter from one segment, measured on REC... (paper, Sec. V-B)", false,
       sigma_ref_cells, sigma_ref_run, sigma_ref_gather},
      {"hidden", "hidden effects in simulated recordings: are they named, and nothing else?", false, hidden_cells,
       hidden_run, hidden_gather},
      {"hidden_real", "hidden effects put into the tracked recording REC (euroc_mh01)", false, hidden_real_cells,
       hidden_real_run, hidden_real_gather},
      {"measured", "rendered images and the real tracker, real IMUs along real paths, euroc_mh01: is any answer wrong?",
       false, measured_cells, measured_run, measured_gather},
      {"faults", "faults of sensors, stamps, trackers and loggers: is each named, and nothing wrong called calibrated?",
       false, faults_cells, faults_run, faults_gather},
      {"soak",
       "a day of stream through one device, faults in every second session: does anything change with the hours?",
       false, soak_cells, soak_run, soak_gather},
  };
  return all;
}

}  // namespace host::experiments
