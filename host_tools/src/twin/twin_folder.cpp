#include "twin/twin_folder.h"

#include <algorithm>

#include "files/output_run.h"

namespace host::twin {
namespace {

bool is_within(const std::filesystem::path& inner, const std::filesystem::path& outer) {
  const std::filesystem::path way = inner.lexically_relative(outer);
  return !way.empty() && *way.begin() != "..";
}

}  // namespace

void expect_twin_folder(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& others) {
  const std::filesystem::path own = std::filesystem::weakly_canonical(folder);
  for (const std::filesystem::path& other : others) {
    const std::filesystem::path full = std::filesystem::weakly_canonical(other);
    if (is_within(own, full) || is_within(full, own))
      throw InputError("--twin " + folder.string() + ": expected a folder of its own, apart from " + other.string());
  }
  expect_output_folder(folder, "simulate", true);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError("--twin " + folder.string() + ": cannot be made (" + error.message() + ")");
}

void write_twin(const SimulationResult& twin, const std::filesystem::path& folder) {
  OutputRun files(folder, "simulate");
  write_simulation(twin, folder);
  files.finish();
}

}  // namespace host::twin
