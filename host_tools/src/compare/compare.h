// Two results, and both against the truth where it is known.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/parameters.h"
#include "compare/trajectory_error.h"

namespace host {

struct CompareOptions {
  std::filesystem::path a, b;
  std::vector<std::filesystem::path> truth;  ///< .json: parameters; else a trajectory
  ErrorOptions trajectory;
  SigmaOf sigma_of = SigmaOf::difference;
  double sigmas = 4;                               ///< tolerance of each parameter
  std::optional<double> sigma_ratio;               ///< tolerance of sigma_A / sigma_B - 1
  std::optional<double> position_m, attitude_rad;  ///< tolerances of trajectory RMSE
};

/// A list of parameter differences and what it is of.
struct ParameterComparison {
  std::string of, against;
  std::vector<ParameterDifference> parameters;
};

struct TrajectoryComparison {
  std::string of, against;
  TrajectoryError error;
};

struct Comparison {
  std::vector<ParameterComparison> parameters;
  std::vector<TrajectoryComparison> trajectories;
  std::vector<std::string> exceeded;  ///< what is above its tolerance, one sentence each
  std::string verdict;                ///< one line
};

/// Reads both folders and compares. Throws InputError where nothing can be compared.
Comparison compare(const CompareOptions& options);

nlohmann::ordered_json comparison_json(const Comparison& comparison, const CompareOptions& options);

}  // namespace host
