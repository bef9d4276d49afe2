// The subcommand `segcal report`: checks the input, then lets Python draw the page (host_tools/report/report.py).
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

#include "commands.h"
#include "csv.h"
#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;

constexpr const char* explanation =
    "Writes DIR/report.html from what `segcal replay` left in DIR: one file that needs no network, readable on a phone.\n"
    "Calibration table with verdicts, the path with the kept segments, metric over time, residuals, biases, timing.";

constexpr const char* footer = R"(Example:
  segcal report out && xdg-open out/report.html

A figure whose data are missing is left out, and the page says so. Python with plotly and numpy draws the page:
$SEGCAL_PYTHON, else the virtual environment that host_tools/setup.sh made, else python3.
Exit code 2: DIR or its result.json is missing or malformed.)";

constexpr int exit_cannot_execute = 127;

/// $SEGCAL_PYTHON, else the source tree's virtual environment, else python3 of the PATH.
std::string python_program() {
  if (const char* const named = std::getenv("SEGCAL_PYTHON"); named != nullptr && *named != '\0') return named;
  const fs::path in_tree = fs::path(SEGCAL_SOURCE_DIR) / ".venv" / "bin" / "python";
  return fs::exists(in_tree) ? in_tree.string() : "python3";
}

/// Runs a program and waits; its exit code, or 128 + signal. Throws InputError if it cannot be started.
int run_program(const std::vector<std::string>& arguments) {
  std::vector<char*> raw;
  for (const std::string& argument : arguments) raw.push_back(const_cast<char*>(argument.c_str()));
  raw.push_back(nullptr);
  const pid_t child = fork();
  if (child < 0) throw InputError(std::string("cannot start a process: ") + std::strerror(errno));
  if (child == 0) {
    execvp(raw[0], raw.data());
    _exit(exit_cannot_execute);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::size_t line_of(const std::string& text, std::size_t byte) {
  std::size_t line = 1;
  for (std::size_t i = 0; i < byte && i < text.size(); ++i) line += text[i] == '\n';
  return line;
}

/// Found here rather than in Python, so that a wrong path is told even where Python is missing.
void check_result(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw InputError(folder.string() + ": expected the folder that `segcal replay --out` wrote");
  const fs::path file = folder / "result.json";
  const std::string text = read_file(file);
  try {
    const nlohmann::json result = nlohmann::json::parse(text);
    if (!result.is_object() || !result.contains("status") || !result.contains("parameters"))
      throw InputError(file.string() + ":1: expected an object with status and parameters");
  } catch (const nlohmann::json::parse_error& error) {
    throw InputError(file.string() + ":" + std::to_string(line_of(text, error.byte)) + ": expected JSON");
  }
}

/// 0, or 2 when the script has told on stderr what is wrong. Throws InputError where it could not tell.
int draw(const fs::path& folder) {
  const std::string python = python_program();
  const fs::path script = fs::path(SEGCAL_SOURCE_DIR) / "host_tools" / "report" / "report.py";
  if (!fs::exists(script)) throw InputError(script.string() + ": file is missing, the report needs the source tree");
  // -B: no compiled files beside the sources.
  const int code = run_program({python, "-B", script.string(), folder.string()});
  if (code == exit_cannot_execute) throw InputError(python + ": expected a Python 3 program; run host_tools/setup.sh");
  if (code != 0 && code != 2) throw InputError(script.string() + ": stopped with exit code " + std::to_string(code));
  return code;
}

}  // namespace

void add_report_command(CLI::App& app, int& exit_code) {
  CLI::App* const sub = app.add_subcommand("report", explanation);
  sub->footer(footer);
  const auto folder = std::make_shared<fs::path>();
  sub->add_option("DIR", *folder, "folder with result.json and report_data.json")->required();
  sub->callback([folder, &exit_code] {
    check_result(*folder);
    exit_code = draw(*folder);
  });
}

}  // namespace host
