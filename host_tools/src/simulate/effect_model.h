// Effects of a model file (replay/model_file.h) for the simulator: what a diagnosis found, put into a device.
#pragma once

#include <filesystem>

#include "effect.h"

namespace host::sim {

/// Throws InputError with file and line for an effect or a parameter that cannot be simulated.
Effects effects_of_model(const std::filesystem::path& file);

}  // namespace host::sim
