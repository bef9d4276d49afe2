// Reproducible studies: `segcal experiments NAME`. A study is a list of independent cells, each a set of parameters and
// a seed; each cell's result is a file of its own, so that a study that was stopped goes on where it was.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace host::experiments {

using Json = nlohmann::ordered_json;

/// A released entry farther from the truth than this is a wrong answer.
constexpr double wrong_sigmas = 5;

struct StudyOptions {
  std::uint64_t seed = 1;
  int seeds = 0;                                  ///< of each kind of cell; 0: as many as the study has
  bool quick = false;                             ///< fewer and shorter sessions: minutes instead of an hour
  std::vector<std::filesystem::path> recordings;  ///< for studies of real recordings
  std::filesystem::path calibration;              ///< where these start; empty: their own
};

struct Cell {
  std::string name;  ///< unique within the study, a file name
  Json parameters;   ///< all that its result depends on
};

/// A cell with its result.
struct CellResult {
  Json parameters, result;
};

struct Column {
  std::string name, unit;  ///< unit "-" for a number without one, "" for text
};

struct Table {
  std::string title, note;
  std::vector<Column> columns;
  std::vector<std::vector<Json>> rows;
};

/// One line or group of bars.
struct Series {
  std::string name;
  std::vector<Json> x;
  std::vector<double> y;
};

struct Figure {
  std::string title, kind;  ///< kind: lines, bars, or boxes (the y of equal x are one box)
  std::string x_label, y_label;
  bool log_y = false;
  std::vector<Series> series;
};

/// A figure that the study is to keep.
struct Limit {
  std::string what;
  double value = 0, limit = 0;
  std::string unit;
  bool at_least = false;  ///< true: value >= limit is met; false: value <= limit
  bool met() const { return at_least ? value >= limit : value <= limit; }
};

struct Findings {
  std::vector<Table> tables;  ///< the first one is NAME.csv too
  std::vector<Figure> figures;
  std::vector<Limit> limits;
  Json values = Json::object();  ///< results for programs to read
};

struct Experiment {
  const char* name;
  const char* description;  ///< one line for --list
  bool alone;               ///< true: cells are timed, so one at a time
  std::vector<Cell> (*cells)(const StudyOptions&);
  Json (*run)(const Json& parameters);
  Findings (*gather)(const std::vector<CellResult>&);
};

const std::vector<Experiment>& experiments();

/// Runs the cells that DIR/cells does not hold with the same parameters yet, up to `jobs` processes at a time, and
/// reads all back in the cells' order. Throws InputError if a cell fails; what the others found stays.
std::vector<CellResult> run_cells(const Experiment& experiment, const std::vector<Cell>& cells,
                                  const std::filesystem::path& dir, int jobs);

/// NAME.csv, NAME.json and report.html.
void write_findings(const Experiment& experiment, const Findings& findings, const StudyOptions& options,
                    const std::filesystem::path& dir);

}  // namespace host::experiments
