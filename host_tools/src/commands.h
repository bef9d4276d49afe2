// The subcommands of the program. Each lives in its own file and adds itself to the command line.
#pragma once

#include <CLI/CLI.hpp>

namespace host {

// Each function adds one subcommand. When that runs it sets `exit_code`: 0 done, 1 done but the answer is negative.
// Bad usage or input is an InputError, which main turns into one line on stderr and exit code 2.
void add_allan_command(CLI::App& app, int& exit_code);
void add_export_command(CLI::App& app, int& exit_code);
void add_import_command(CLI::App& app, int& exit_code);
void add_replay_command(CLI::App& app, int& exit_code);
void add_track_command(CLI::App& app, int& exit_code);
void add_simulate_command(CLI::App& app, int& exit_code);
void add_reference_command(CLI::App& app, int& exit_code);
void add_report_command(CLI::App& app, int& exit_code);
void add_compare_command(CLI::App& app, int& exit_code);
void add_convert_command(CLI::App& app, int& exit_code);
void add_diagnose_command(CLI::App& app, int& exit_code);
void add_experiments_command(CLI::App& app, int& exit_code);
void add_fleet_command(CLI::App& app, int& exit_code);

}  // namespace host
