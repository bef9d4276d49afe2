// What a simulation takes over from a recording, in the place of what it would draw: a twin of it.
#pragma once

#include <utility>
#include <vector>

#include "../calibration_file.h"
#include "trajectory_fit.h"

namespace host::sim {

/// Times in s since the first pose.
struct Replica {
  PoseSeries poses;                                          ///< the motion
  std::vector<Eigen::Vector3d> landmarks_G;                  ///< m
  Calibration device;                                        ///< what the twin really is
  Calibration start;                                         ///< what an estimator starts from
  std::vector<std::pair<double, double>> temperatures_degC;  ///< empty: the recording has none
  std::vector<std::pair<double, double>> exposures_s;        ///< empty: the recording has none
};

/// The value at or before t, the first one where there is none before; `values` in order of time, not empty.
double latest(const std::vector<std::pair<double, double>>& values, double t);

}  // namespace host::sim
