// What a study leaves behind: NAME.csv, NAME.json, and the page that is drawn from it.
#include <cmath>

#include "experiments/experiment.h"
#include "files/output_run.h"
#include "python_script.h"
#include "recording.h"

namespace host::experiments {
namespace {

std::string label(const Column& column) {
  return column.unit.empty() ? column.name : column.name + " [" + column.unit + "]";
}

/// A field of a CSV file, quoted where it has to be.
std::string field(const Json& value) {
  if (!value.is_string()) return value.is_null() ? "" : value.dump();
  const std::string text = value.get<std::string>();
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_of(const Table& table) {
  std::string text;
  for (std::size_t i = 0; i < table.columns.size(); ++i) text += (i ? "," : "") + field(label(table.columns[i]));
  text += "\n";
  for (const auto& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) text += (i ? "," : "") + field(row[i]);
    text += "\n";
  }
  return text;
}

Json json_of(const Table& table) {
  Json columns = Json::array();
  for (const Column& column : table.columns) columns.push_back(label(column));
  return {{"title", table.title}, {"note", table.note}, {"columns", columns}, {"rows", table.rows}};
}

Json json_of(const Figure& figure) {
  Json series = Json::array();
  for (const Series& s : figure.series) series.push_back({{"name", s.name}, {"x", s.x}, {"y", s.y}});
  return {{"title", figure.title}, {"kind", figure.kind},   {"x", figure.x_label},
          {"y", figure.y_label},   {"log_y", figure.log_y}, {"series", series}};
}

Json json_of(const Limit& limit) {
  return {{"what", limit.what}, {"value", limit.value},       {"limit", limit.limit},
          {"unit", limit.unit}, {"at_least", limit.at_least}, {"met", limit.met()}};
}

}  // namespace

void write_findings(const Experiment& experiment, const Findings& findings, const StudyOptions& options,
                    const std::filesystem::path& dir) {
  Json json = {{"format", 1},
               {"experiment", experiment.name},
               {"description", experiment.description},
               {"seed", options.seed},
               {"quick", options.quick}};
  for (const char* list : {"limits", "tables", "figures"}) json[list] = Json::array();
  for (const Limit& limit : findings.limits) json["limits"].push_back(json_of(limit));
  for (const Table& table : findings.tables) json["tables"].push_back(json_of(table));
  for (const Figure& figure : findings.figures) json["figures"].push_back(json_of(figure));
  json["values"] = findings.values;
  const std::string name = experiment.name;
  OutputRun files(dir, "experiments " + name, FolderRole::guest);
  if (!findings.tables.empty()) write_file(dir / (name + ".csv"), csv_of(findings.tables.front()));
  write_file(dir / (name + ".json"), json.dump(1) + "\n");
  files.finish();
  if (run_python_script("report/experiment.py", {(dir / (name + ".json")).string()}) != 0) {
    throw InputError((dir / "report.html").string() + ": not written; the tables are in " + name + ".json and " + name +
                     ".csv");
  }
}

}  // namespace host::experiments
