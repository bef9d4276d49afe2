// config.yaml: what a replay believes of the sensors before it has seen any data (docs/formats.md).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "replay/core.h"

namespace host {

/// What a config.yaml states; an empty entry is left as it is.
struct SensorConfig {
  PriorSigmas prior_sigma;        ///< 0: not stated
  std::optional<double> gravity;  ///< m/s^2
  std::optional<double> gyro_noise_density, gyro_random_walk, accel_noise_density, accel_random_walk;
  std::optional<double> pixel_sigma, track_walk;

  void apply(CoreOptions* options) const;
};

/// Throws InputError with file and line: another format, an entry of a
/// name that there is not, a number outside its range, two gravities.
SensorConfig read_config_file(const std::filesystem::path& file);

/// All that the options state or take by default, so that a replay with it repeats the run.
std::string config_yaml(const CoreOptions& options);

/// A file with every entry, for --help.
std::string config_help();

/// The sigma of each entry of theta, in the order of the results; 0: the core's default.
std::vector<double> prior_sigmas(const PriorSigmas& stated, const Calibration& start);

}  // namespace host
