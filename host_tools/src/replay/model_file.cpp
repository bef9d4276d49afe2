#include "replay/model_file.h"

#include <cstdio>

#include "file_output.h"
#include "replay/temperature_use.h"
#include "replay/words.h"
#include "sensors/effect_names.h"
#include "yaml_file.h"

namespace host {
namespace {

using namespace SEGCAL_NS;

std::string effect_names() {
  std::string out;
  for (int e = 0; e < kEffects; ++e) out += std::string(e > 0 ? ", " : "") + effect_entry(e).name;
  return out;
}

/// -1: there is none of that name.
int find_name(const std::string& effect) {
  int e = kEffects - 1;
  while (e >= 0 && effect != effect_entry(e).name) --e;
  return e;
}

std::string name_of(const Term& t) {
  char name[64], unit[64];
  write_term_name(t, name, sizeof name, unit, sizeof unit);
  return name;
}

/// Every term that has a name is tried: some two thousand.
bool find_term(const std::string& name, Term* out) {
  const auto byte = [](int i) { return static_cast<std::uint8_t>(i); };
  for (int kind = 0; kind <= static_cast<int>(TermKind::accel_z); ++kind) {
    for (int a = 0; a < kNamedSignals; ++a) {
      for (int b = 0; b < kNamedSignals; ++b) {
        *out = {static_cast<TermKind>(kind), byte(a), byte(b), 0};
        if (name_of(*out) == name) return true;
      }
    }
  }
  for (const TermKind kind : {TermKind::image_u, TermKind::image_v}) {
    for (int i = 0; i < 7 * 7 * 7; ++i) {
      *out = {kind, byte(i % 7), byte(i / 7 % 7), byte(i / 49)};
      if (name_of(*out) == name) return true;
    }
  }
  return false;
}

std::string yaml_digits(const char* format, double value) {
  char digits[40];
  std::snprintf(digits, sizeof digits, format, value);
  return yaml_number(digits);
}

}  // namespace

void EffectChoice::enable(const std::string& effect) {
  const int e = find_name(effect);
  if (e < 0) throw InputError("--enable: there is no effect '" + effect + "'; expected one of " + effect_names());
  effects_ |= 1u << e;
}

void EffectChoice::set(const std::string& parameter, double value) {
  const int e = find_name(parameter.substr(0, parameter.find('.')));
  for (int i = 0; e >= 0 && i < effect_entry(e).n; ++i) {
    if (name_of(effect_term(e, i)) != parameter) continue;
    value_[parameter] = value;
    return;
  }
  throw InputError("there is no parameter '" + parameter + "'");
}

bool EffectChoice::enabled(const std::string& effect) const {
  const int e = find_name(effect);
  return e >= 0 && (effects_ >> e & 1u) != 0;
}

bool EffectChoice::follows_temperature() const {
  return has_term_of_temperature_ || enabled("gyro_temperature") || enabled("accel_temperature") ||
         enabled("camera_temperature");
}

double EffectChoice::value(const std::string& parameter) const {
  const auto found = value_.find(parameter);
  return found == value_.end() ? 0 : found->second;
}

void EffectChoice::add_term(const std::string& name, double value) {
  Term t;
  if (!find_term(name, &t))
    throw InputError("there is no term '" + name + "'; expected one as gyro_x:fy*wz, accel_z:T or image_u:x^2*y");
  terms_.push_back({static_cast<int>(t.kind), t.a, t.b, t.c});
  term_values_.push_back(value);
  has_term_of_temperature_ |= is_of_temperature(name);
}

void EffectChoice::apply(CoreOptions* options) const {
  options->effects = effects_;
  options->terms = terms_;
  options->term_values.clear();
  for (int e = 0; e < kEffects; ++e) {
    for (int i = 0; (effects_ >> e & 1u) && i < effect_entry(e).n; ++i) {
      const auto value = value_.find(name_of(effect_term(e, i)));
      options->term_values.push_back(value == value_.end() ? 0 : value->second);
    }
  }
  options->term_values.insert(options->term_values.end(), term_values_.begin(), term_values_.end());
}

EffectChoice read_model(const std::filesystem::path& file) {
  return read_yaml(file, [](const YamlFile& yaml) {
    if (yaml.number_or(yaml.root(), "format", 0) != 1) yaml.fail(yaml.root(), "'format: 1' here");
    EffectChoice choice;
    const YAML::Node effects = yaml.child(yaml.root(), "effects");
    if (!effects.IsSequence() && !effects.IsNull()) yaml.fail(effects, "a list of effects");
    for (const YAML::Node& effect : effects) {
      const std::string name = yaml.text(effect, "name");
      if (name != "term" && find_name(name) < 0) yaml.fail(effect, "'name' to be term or one of " + effect_names());
      if (name != "term") choice.enable(name);
      for (const YAML::Node& p : effect["parameters"]) {
        const std::string parameter = yaml.text(p, "name");
        const double value = yaml.number(p, "value");
        try {
          name == "term" ? choice.add_term(parameter, value) : choice.set(name + "." + parameter, value);
        } catch (const InputError& error) {
          yaml.fail(p, std::string("a parameter of ") + name + " (" + error.what() + ")");
        }
      }
    }
    return choice;
  });
}

std::string model_yaml(const ReplayResult& result) {
  const std::vector<CoreParameter>& all = result.result.parameters;
  const std::size_t first = parameter_names(result.calibration).size();
  std::string text = "# Effects beside theta that are active in this calibration.\nformat: 1\n", last;
  text += all.size() > first ? "effects:\n" : "effects: []\n";
  for (std::size_t i = first; i < all.size(); ++i) {
    const std::size_t dot = all[i].name.find('.');
    const bool listed = dot != std::string::npos;
    const std::string effect = listed ? all[i].name.substr(0, dot) : "term";
    if (effect != last) text += "  - name: " + effect + "\n    parameters:\n";
    last = effect;
    text += "      - {name: \"" + (listed ? all[i].name.substr(dot + 1) : all[i].name) +
            "\", value: " + yaml_digits("%.9g", all[i].value) + ", sigma: " + yaml_digits("%.4g", all[i].sigma) +
            ", unit: \"" + all[i].unit + "\", verdict: " + all[i].verdict + "}\n";
  }
  return text;
}

std::string effects_help() {
  std::string out = "Effects (--enable NAME), with their parameters:\n";
  for (int e = 0; e < kEffects; ++e) {
    const EffectEntry& entry = effect_entry(e);
    std::string parameters;
    for (int i = 0; i < entry.n; ++i) parameters += std::string(i > 0 ? " " : "") + entry.parameter[i];
    out += std::string("  ") + entry.name + " [" + parameters + ", " + entry.unit + "]\n      shows as " +
           entry.looks_like + "\n      confounded with " + entry.confounded + "\n";
  }
  return out + "A model.yaml written by a replay can be the --model of the next one.\n";
}

}  // namespace host
