// Effects by name, as the command line and the experiments give them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "effect.h"

namespace host::sim {

enum class EffectKind {
  catalogue,  ///< docs/diagnosis.md, section 4
  fault,      ///< of wiring, units, clocks: what is found before any fit
  outside     ///< names begin with "outside:"
};

/// One effect that can be simulated.
struct EffectEntry {
  EffectKind kind;
  const char* name;
  const char* values;   ///< names and units of its values, for --help
  const char* example;  ///< a size that shows in a minute of rich motion
  std::shared_ptr<const Effect> (*make)(const std::vector<std::string>& values);
};

const std::vector<EffectEntry>& effect_entries();

/// "NAME=v1,v2,..." to an effect. Throws InputError that says what was expected.
std::shared_ptr<const Effect> parse_effect(const std::string& text);

/// A line per effect of that kind: name=values, units, an example.
std::string effect_help(EffectKind kind);

}  // namespace host::sim
