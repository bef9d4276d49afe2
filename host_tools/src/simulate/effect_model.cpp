#include "effect_model.h"

#include "../file_output.h"
#include "../yaml_file.h"
#include "effect_names.h"
#include "sensors/effect_names.h"

namespace host::sim {
namespace {

/// Number of the effect in the core's catalogue, whose parameters have the simulator's order; -1: there is none.
int number_of(const std::string& name) {
  int e = SEGCAL_NS::kEffects - 1;
  while (e >= 0 && name != SEGCAL_NS::effect_entry(e).name) --e;
  return e;
}

int place_of(const SEGCAL_NS::EffectEntry& entry, const std::string& parameter) {
  int i = entry.n - 1;
  while (i >= 0 && parameter != entry.parameter[i]) --i;
  return i;
}

/// "NAME=v1,v2,...": parameters that are not listed are zero.
std::string as_text(const YamlFile& yaml, const YAML::Node& effect) {
  const std::string name = yaml.text(effect, "name");
  const int e = number_of(name);
  if (e < 0) yaml.fail(effect, "an effect of the catalogue ('" + name + "' cannot be simulated from a model file)");
  const SEGCAL_NS::EffectEntry& entry = SEGCAL_NS::effect_entry(e);
  std::vector<double> values(static_cast<std::size_t>(entry.n), 0.0);
  for (const YAML::Node& p : effect["parameters"]) {
    const int place = place_of(entry, yaml.text(p, "name"));
    if (place < 0) yaml.fail(p, "a parameter of " + name);
    values[static_cast<std::size_t>(place)] = yaml.number(p, "value");
  }
  std::string text = name;
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += i == 0 ? '=' : ',';
    append_number(text, values[i]);
  }
  return text;
}

}  // namespace

Effects effects_of_model(const std::filesystem::path& file) {
  return read_yaml(file, [](const YamlFile& yaml) {
    if (yaml.number_or(yaml.root(), "format", 0) != 1) yaml.fail(yaml.root(), "'format: 1' here");
    const YAML::Node effects = yaml.child(yaml.root(), "effects");
    if (!effects.IsSequence() && !effects.IsNull()) yaml.fail(effects, "a list of effects");
    Effects out;
    for (const YAML::Node& effect : effects) {
      const std::string text = as_text(yaml, effect);
      try {
        out.push_back(parse_effect(text));
      } catch (const InputError& error) {
        yaml.fail(effect, std::string("values that can be simulated (") + error.what() + ")");
      }
    }
    return out;
  });
}

}  // namespace host::sim
