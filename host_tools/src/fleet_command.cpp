// The subcommand `segcal fleet`: Python starts this program for each log (host_tools/fleet/fleet.py).
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "commands.h"
#include "python_script.h"
#include "recording.h"

namespace host {
namespace {

constexpr const char* fleet_explanation =
    "Replays many logs on all cores or on a cluster, and fuses their results per device and per model.\n"
    "All options: segcal fleet --help";

/// Of fleet.py: done, but the answer is negative. 1 is what Python ends with after an error of its own.
constexpr int kNegative = 3;

}  // namespace

void add_fleet_command(CLI::App& app, int& exit_code) {
  CLI::App* const sub = app.add_subcommand("fleet", fleet_explanation);
  sub->set_help_flag();  // argparse explains the options: they are its own
  sub->prefix_command();
  sub->callback([sub, &exit_code] {
    for (const std::string& argument : sub->remaining())
      if (argument.empty()) throw InputError("fleet: expected values, found an empty text");
    setenv("SEGCAL_PROGRAM", std::filesystem::read_symlink("/proc/self/exe").c_str(), 1);
    const int code = run_python_script("fleet/fleet.py", sub->remaining(), kNegative);
    exit_code = code == kNegative ? 1 : code;
  });
}

}  // namespace host
