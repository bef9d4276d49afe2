// The folder in which a twin is left as a recording.
#pragma once

#include <filesystem>
#include <vector>

#include "simulate/simulate.h"

namespace host::twin {

/// For the beginning of a command. Throws InputError where `folder` is one of the others, inside one or around one,
/// belongs to somebody else, or cannot be made. It exists then.
void expect_twin_folder(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& others);

/// As `segcal simulate --out` leaves it.
void write_twin(const SimulationResult& twin, const std::filesystem::path& folder);

}  // namespace host::twin
