// The subcommand `segcal report`: checks the input, then lets Python draw the page (host_tools/report/report.py).
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "commands.h"
#include "csv.h"
#include "files/manifest.h"
#include "python_script.h"
#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;

constexpr const char* report_explanation =
    "Writes DIR/report.html from what `segcal replay`, `diagnose` or `allan` left in DIR: one file that needs no "
    "network, readable on a\n"
    "phone and on paper. Of a replay: what happened and why, the calibration, its way there, the path, what each "
    "segment told, residuals\n"
    "over the image and over time, how tracks drift, biases, timing.";

constexpr const char* report_footer = R"(Example:
  segcal report out && xdg-open out/report.html

Figures without data are left out, with a note on the page. Python with plotly and numpy draws the page:
$SEGCAL_PYTHON, else the virtual environment that host_tools/setup.sh made, else python3.
Exit code 2: DIR or a file of it is missing or malformed; one line says which and where.)";

std::size_t line_of(const std::string& text, std::size_t byte) {
  std::size_t line = 1;
  for (std::size_t i = 0; i < byte && i < text.size(); ++i) line += text[i] == '\n';
  return line;
}

/// Found here rather than in Python, so that a wrong path is told even where Python is missing.
void check_result(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw InputError(folder.string() +
                     ": expected the folder that `segcal replay`, `diagnose` or `allan` wrote (--out)");
  check_folder(folder);
  if (!fs::exists(folder / "diagnosis.json") && fs::exists(folder / "allan.json")) return;  // report.py looks into it
  const bool diagnosed = fs::exists(folder / "diagnosis.json");
  const fs::path file = folder / (diagnosed ? "diagnosis.json" : "result.json");
  const std::string text = read_file(file);
  try {
    const nlohmann::json result = nlohmann::json::parse(text);
    if (diagnosed && result.is_object() && result.contains("verdict")) return;
    if (!result.is_object() || !result.contains("status") || !result.contains("parameters"))
      throw InputError(file.string() + ":1: expected an object with " +
                       (diagnosed ? "verdict" : "status and parameters"));
  } catch (const nlohmann::json::out_of_range& error) {
    throw InputError(file.string() + ": expected JSON with numbers that fit a double: " + error.what());
  } catch (const nlohmann::json::parse_error& error) {
    throw InputError(file.string() + ":" + std::to_string(line_of(text, error.byte)) + ": expected JSON");
  }
}

}  // namespace

void add_report_command(CLI::App& app, int& exit_code) {
  CLI::App* const sub = app.add_subcommand("report", report_explanation);
  sub->footer(report_footer);
  const auto folder = std::make_shared<fs::path>();
  sub->add_option("DIR", *folder, "folder that `segcal replay`, `diagnose` or `allan` wrote")->required();
  sub->callback([folder, &exit_code] {
    check_result(*folder);
    exit_code = run_python_script("report/report.py", {folder->string()});
  });
}

}  // namespace host
