// The ways to get a calibration that the studies compare, as a table. A method that this program does not offer (its
// core has no such metric) is left out of the tables.
#pragma once

#include "experiments/datasets.h"
#include "replay/replay.h"

namespace host::experiments {

/// A calibration after one session.
struct SessionCalibration {
  Calibration calibration;
  CoreResult result;  ///< of the calibration; without parameters where the method has none
};

struct MethodOptions {
  bool multi_session = false;
  int segments = 8;
  bool condense = false;   ///< segments that end after a release go into epochs
  std::uint64_t seed = 1;  ///< of random
};

struct Method {
  const char* name;
  const char* words;
  bool (*offered)();
  std::vector<SessionCalibration> (*run)(const std::vector<Recording>& sessions, const Calibration& start,
                                         const Method& method, const MethodOptions& options);
  const char* metric;                  ///< of the database, where the method has one
  Odometry odometry = Odometry::held;  ///< how its calibrations are evaluated
};

/// Those that are offered.
const std::vector<Method>& methods();
const Method& method_named(const std::string& name);

/// The device's calibration after each of the sessions, starting from the data sheet's.
std::vector<SessionCalibration> calibrate(const std::string& method, const std::vector<SimulationResult>& sessions,
                                          const MethodOptions& options);

}  // namespace host::experiments
