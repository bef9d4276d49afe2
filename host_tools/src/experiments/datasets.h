// The sessions of the studies: what the paper recorded (table I), simulated.
#pragma once

#include <string>
#include <vector>

#include "experiments/experiment.h"
#include "replay/core.h"
#include "simulate/simulate.h"

namespace host::experiments {

/// One device in one environment, several sessions.
struct Dataset {
  const char* name;
  const char* scenario;
  bool multi_session;  ///< the paper's strategy for the use case (Sec. VI-A)
  int sessions;
  double session_s;
  int tracks;            ///< corners alive at a time: the texture
  double near_m, far_m;  ///< distances of landmarks
};

/// AR/VR in an office and a class room, navigation in a parking garage and an office building.
const std::vector<Dataset>& datasets();
const Dataset& dataset_named(const std::string& name);

/// Session `index` of a dataset. The device depends on `seed` alone, so that all datasets of a seed share it.
SimulationResult simulate_session(const Dataset& dataset, std::uint64_t seed, int index, double session_s);

/// The session of a cell with "scenario", "seconds" and "seed".
SimulationResult simulate_cell(const Json& parameters);

/// A session for the evaluation of a calibration: other motion, other landmarks, the same device. Walking, handling and
/// shaking in turn, as the paper's sessions in the motion capture room are mixed.
SimulationResult simulate_evaluation(std::uint64_t seed, int index, double session_s);

/// What the odometry does with the calibration that it is given: it runs with it as it is, as the paper's does, or goes
/// on estimating it in the filter, as this one does unless told otherwise.
enum class Odometry { held, estimating };

/// RMSE after yaw and position alignment with the truth, from 15 s after the start on; no segments are used.
struct OdometryError {
  double position_m = 0, attitude_rad = 0;
};
OdometryError odometry_error(const SimulationResult& session, const Calibration& calibration, Odometry odometry);

/// Over `count` evaluation sessions of `session_s` seconds: {"position_cm": [...], "attitude_deg": [...]}.
class Evaluation {
 public:
  Evaluation(std::uint64_t seed, int count, double session_s);
  Json operator()(const Calibration& calibration, Odometry odometry = Odometry::held) const;

 private:
  std::vector<SimulationResult> sessions_;
};

/// (value - truth) / sigma and others by parameter: [{name, unit, value, sigma, prior_sigma, verdict, initial, truth}].
Json parameters_json(const CoreResult& result, const Calibration& truth);

}  // namespace host::experiments
