#include "command_line.h"

#include <signal.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <string>

#include "commands.h"
#include "recording.h"

namespace host {
namespace {

constexpr int exit_bad_input = 2;

constexpr const char* walk_through = R"(First steps:
  segcal simulate --out rec --scenario arvr --seconds 60 --seed 1   make a recording, nothing to download
  segcal replay rec --out out                                       calibrate from it: out/result.json
  segcal report out                                                 out/report.html: table, path, residuals

With a log of your own (ROS bag, MCAP, phone log, ...); EuRoC's folder layout works without it:
  segcal import LOG --out REC                                       one folder with IMU, images, calibration
  segcal track REC                                                  images to REC/mav0/cam0/tracks.csv
  segcal replay REC --calib START.yaml --out out

Exit codes:
  0  done
  1  done, but the answer is negative: not calibrated, or a tolerance missed
  2  bad usage or input; one line on stderr names file, line and what was expected

`segcal COMMAND --help` explains a command.)";

/// One line, however many the message has.
std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

int complain(const std::string& message) {
  std::cerr << "segcal: " << one_line(message) << std::endl;
  return exit_bad_input;
}

/// An answer that did not arrive is no answer: a full disk, a closed pipe.
int with_output_checked(int exit_code) {
  errno = 0;
  const bool written = std::cout.flush().good() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (written) return exit_code;
  const int why = errno;
  return complain(std::string("standard output: cannot be written") +
                  (why != 0 ? std::string(": ") + std::strerror(why) : ""));
}

/// No file, folder or name is empty: an empty one is a shell
/// variable that was not set, and would mean the current folder.
void refuse_empty_texts(CLI::App& app) {
  const CLI::Validator not_empty(
      [](std::string& text) { return text.empty() ? "expected a value, found an empty text" : ""; }, "");
  for (CLI::App* const sub : app.get_subcommands({}))
    for (CLI::Option* const option : sub->get_options())
      if (option->get_items_expected_max() > 0) option->check(not_empty);
}

int run(int argc, char** argv) {
  CLI::App app("segcal keeps a camera and IMU calibrated, from recordings or in firmware.", "segcal");
  app.set_version_flag("--version", "segcal " SEGCAL_PROGRAM_VERSION);
  app.require_subcommand(1);

  int exit_code = 0;
  add_simulate_command(app, exit_code);
  add_import_command(app, exit_code);
  add_track_command(app, exit_code);
  add_replay_command(app, exit_code);
  add_reference_command(app, exit_code);
  add_report_command(app, exit_code);
  add_export_command(app, exit_code);
  add_allan_command(app, exit_code);
  add_compare_command(app, exit_code);
  add_convert_command(app, exit_code);
  add_diagnose_command(app, exit_code);
  add_experiments_command(app, exit_code);
  add_fleet_command(app, exit_code);
  refuse_empty_texts(app);
  app.footer(walk_through);  // last: a subcommand would inherit it

  const std::string command = argc > 1 ? argv[1] : "";
  const bool known = app.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == command; }).size() == 1;
  if (!command.empty() && command.front() != '-' && !known)
    return complain("expected one of the commands in segcal --help, found '" + command + "'");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version
    return complain(std::string(error.what()) + " (see segcal " + (known ? command + " --help)" : "--help)"));
  }
  return exit_code;
}

}  // namespace

int run_command_line(int argc, char** argv) {
  signal(SIGPIPE, SIG_IGN);  // a closed pipe is an error of the write, told like a full disk
  try {
    return with_output_checked(run(argc, argv));
  } catch (const std::exception& error) {  // InputError, and what the libraries throw on files they cannot use
    return complain(error.what());
  }
}

}  // namespace host
