#include "effect_options.h"

#include "effect_model.h"
#include "effect_names.h"

namespace host::sim {
namespace {

/// One without values is one of the study's.
void take_fault(const std::string& text, SimulationOptions* options, std::vector<const FaultKind*>* spoil) {
  if (text.find('=') != std::string::npos) return options->effects.push_back(parse_effect(text));
  const FaultKind& kind = fault_kind(text);
  if (options->images)
    throw InputError("--fault " + text + ": changes tracks and samples, which --images has none of; leave one away");
  if (!kind.effect.empty()) options->effects.push_back(parse_effect(kind.effect));
  spoil->push_back(&kind);
}

}  // namespace

void add_effect_options(CLI::App& app, EffectOptions* options) {
  app.add_option("--effect", options->effects,
                 "NAME=v1,v2,...: an effect that the calibrated model has no parameter for; repeatable. "
                 "Sizes that are visible\n"
                 "in a minute of rich motion, with names and units of the values:\n" +
                     effect_help(EffectKind::catalogue))
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--model", options->model,
                 "model.yaml of a diagnosis or a replay: its effects, with its values, before those of --effect");
  app.add_option("--fault", options->faults,
                 "NAME=v1,...: a fault of wiring, units or clocks; repeatable:\n" + effect_help(EffectKind::fault) +
                     "or one of `segcal experiments faults`, at its size: " + fault_kind_names())
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option(
         "--temperature", options->temperature,
         "BEGIN,END[,TIME CONSTANT]: degC, degC, s: temperature column of an IMU that warms up; without it effects\n"
         "that need one take 25,40 and a third of the recording")
      ->expected(1, 3)
      ->delimiter(',')
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

std::vector<const FaultKind*> take_effects(const EffectOptions& given, SimulationOptions* options) {
  std::vector<const FaultKind*> spoil;
  if (!given.model.empty()) options->effects = effects_of_model(given.model);
  for (const std::string& text : given.effects) options->effects.push_back(parse_effect(text));
  for (const std::string& text : given.faults) take_fault(text, options, &spoil);
  const std::vector<double>& t = given.temperature;
  if (t.empty()) return spoil;
  if (t.size() < 2 || (t.size() == 3 && !(t[2] > 0)))
    throw InputError("--temperature: expected BEGIN,END[,TIME CONSTANT], degC, degC, s above 0");
  options->temperature = WarmUp{t[0], t[1], t.size() == 3 ? t[2] : options->seconds / 3};
  return spoil;
}

}  // namespace host::sim
