// model.yaml: the effects that a calibration has beside theta, with values, sigmas and units (docs/formats.md).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "replay/replay.h"

namespace host {

/// Effects to estimate, and where they start.
class EffectChoice {
 public:
  /// An effect of the catalogue. Throws InputError with all names for another one. Twice is once.
  void enable(const std::string& effect);
  /// A term by its name, "gyro_x:fy*wz"; `value` is its start. Throws InputError for a term that there is not.
  void add_term(const std::string& name, double value);
  /// Start of a parameter, "time_offset.t_d". Throws InputError if the effect has none of that name.
  void set(const std::string& parameter, double value);
  bool enabled(const std::string& effect) const;
  /// Some effect or term of it is one of temperature.
  bool follows_temperature() const;
  /// Start of a parameter; 0 where none was set.
  double value(const std::string& parameter) const;
  /// Puts the choice into the core's options.
  void apply(CoreOptions* options) const;

 private:
  std::uint32_t effects_ = 0;
  std::map<std::string, double> value_;  ///< of parameters
  std::vector<CoreTerm> terms_;
  std::vector<double> term_values_;
  bool has_term_of_temperature_ = false;
};

/// Throws InputError with file and line where it is no model of format 1.
EffectChoice read_model(const std::filesystem::path& file);
std::string model_yaml(const ReplayResult& result);
/// The catalogue as a paragraph of help: name, parameters and unit, what it looks like.
std::string effects_help();

}  // namespace host
