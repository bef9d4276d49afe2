// The options of `segcal simulate` by which a device departs from its model, or a recording from a sound one.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "fault_kinds.h"
#include "simulate.h"

namespace host::sim {

/// As given on the command line.
struct EffectOptions {
  std::vector<std::string> effects, faults;
  std::filesystem::path model;
  std::vector<double> temperature;
};

/// `options` must live as long as `app` is parsed.
void add_effect_options(CLI::App& app, EffectOptions* options);

/// Puts effects and temperature into `options`, after its seconds and images are known. Returns what is to spoil the
/// recording. Throws InputError that says what was expected.
std::vector<const FaultKind*> take_effects(const EffectOptions& given, SimulationOptions* options);

}  // namespace host::sim
