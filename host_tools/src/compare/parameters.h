// Calibrations as lists of named parameters with sigmas, from the folders that the commands write.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace host {

struct ParameterEstimate {
  std::string name, unit;
  double value = 0;
  std::optional<double> sigma;  ///< none: a calibration file without uncertainty, or the truth
  std::string verdict;          ///< observed, weak, fixed, or nothing
};
using ParameterList = std::vector<ParameterEstimate>;

/// Of a folder: result.json; where that is missing or holds no parameters,
/// camchain-imucam.yaml and imu.yaml, without sigmas. Throws InputError.
ParameterList read_parameters(const std::filesystem::path& dir);

/// truth.json as `segcal simulate` writes it: {"format": 1, "parameters": [{name, value}]}. Throws InputError.
ParameterList read_truth_parameters(const std::filesystem::path& file);

/// Which sigma a difference is measured with. `a` and `b` are
/// for results of the same data, whose difference is not noise.
enum class SigmaOf { difference, a, b };
SigmaOf sigma_of_from_name(const std::string& name);  ///< difference, a, b. Throws InputError.

struct ParameterDifference {
  std::string name, unit;
  double a = 0, b = 0, difference = 0;  ///< difference: a - b
  std::optional<double> sigma_a, sigma_b;
  std::optional<double> in_a, in_b, in_difference;  ///< of sigma of A, of B, of the difference (sqrt(a^2 + b^2))
  std::optional<double> judged(SigmaOf which) const;
};

/// Parameters that both have, in the order of `a`. Rotation
/// vectors that differ by a full turn are brought together first.
std::vector<ParameterDifference> differences(const ParameterList& a, const ParameterList& b);

}  // namespace host
