// The paper's figure 9: how many segments are enough?
#include <map>

#include "experiments/methods.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"

namespace host::experiments {
namespace {

constexpr int largest_size = 15;  // what profile mobile holds
constexpr int everything = 0;     // stands for all segments

}  // namespace

std::vector<Cell> database_size_cells(const StudyOptions& options) {
  std::vector<Cell> cells;
  std::vector<int> sizes;
  for (int size = everything; size <= largest_size; ++size) {
    // Where the curve is steep, each; where it is flat, some.
    if (!options.quick || size <= 2 || size % 4 == 0 || size == 6 || size == largest_size) sizes.push_back(size);
  }
  for (const Dataset& d : datasets()) {
    if (options.quick && &d != &datasets().front() && &d != &datasets().back()) continue;  // one of each use case
    for (int session = 0; session < (options.quick ? 1 : d.sessions); ++session) {
      for (const int size : sizes) {
        cells.push_back({std::string(d.name) + "_session" + std::to_string(session) + "_size" + std::to_string(size),
                         {{"dataset", d.name}, {"session", session}, {"segments", size}, {"session_s", d.session_s},
                          {"evaluations", options.quick ? 3 : 15}, {"evaluation_s", options.quick ? 60 : 114},
                          {"seed", options.seed}}});
      }
    }
  }
  return cells;
}

Json database_size_run(const Json& parameters) {
  const Dataset& dataset = dataset_named(parameters.at("dataset"));
  const std::uint64_t seed = parameters.at("seed");
  const int size = parameters.at("segments");
  const std::vector<SimulationResult> sessions = {simulate_session(dataset, seed, parameters.at("session"), parameters.at("session_s"))};
  MethodOptions options;
  options.segments = size;
  const SessionCalibration found = calibrate(size == everything ? "all" : "A", sessions, options).back();
  const Evaluation evaluation(seed, parameters.at("evaluations"), parameters.at("evaluation_s"));
  Json out = evaluation(found.calibration);
  out["status"] = found.result.status;
  out["segments_kept"] = found.result.segments;
  out["parameters"] = parameters_json(found.result, sessions.front().truth);
  return out;
}

Findings database_size_gather(const std::vector<CellResult>& cells) {
  struct Group {
    std::vector<double> cm, deg, against_all, sigma_ratio, squares;
    int calibrated = 0, runs = 0;
  };
  std::map<std::string, Json> all;  // by dataset and session
  const auto place = [](const CellResult& c) { return c.parameters.at("dataset").get<std::string>() + c.parameters.at("session").dump(); };
  for (const CellResult& c : cells) {
    if (c.parameters.at("segments") == everything) all[place(c)] = c.result;
  }
  std::map<std::pair<std::string, int>, Group> groups;
  for (const CellResult& c : cells) {
    const std::string scenario = dataset_named(c.parameters.at("dataset")).scenario;
    Group& g = groups[{scenario, c.parameters.at("segments")}];
    const Json& base = all.at(place(c));
    for (std::size_t i = 0; i < c.result.at("position_cm").size(); ++i) {
      g.cm.push_back(c.result.at("position_cm").at(i));
      g.deg.push_back(c.result.at("attitude_deg").at(i));
      g.against_all.push_back(g.cm.back() / base.at("position_cm").at(i).get<double>());
    }
    const Json &a = c.result.at("parameters"), &b = base.at("parameters");
    for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
      const double sigma = a[i].at("sigma");
      g.sigma_ratio.push_back(sigma / b[i].at("sigma").get<double>());
      if (a[i].at("verdict") == "fixed") continue;
      const double error = (a[i].at("value").get<double>() - a[i].at("truth").get<double>()) / sigma;
      g.squares.push_back(error * error);
    }
    ++g.runs;
    g.calibrated += c.result.at("status") == "calibrated";
  }
  Findings out;
  Table table{"Database size", "A-optimality, segments of 4 s, each session by itself. Size 0: all segments, up to 64. Ratios against "
              "all: position, median over the same pairs; sigmas, geometric mean over parameters and sessions.",
              {{"use case", ""}, {"segments", "-"}, {"position", "cm"}, {"attitude", "deg"}, {"position against all", "-"},
               {"sigmas against all", "-"}, {"mean (error/sigma)^2", "-"}, {"calibrated", "-"}, {"sessions", "-"}}, {}};
  Figure rmse{"Position RMSE", "lines", "segments", "RMSE against all [-]", true, {}};
  Figure sigma{"Sigmas", "lines", "segments", "sigma against all [-]", true, {}};
  std::map<std::string, Series> rmse_lines, sigma_lines;
  for (const auto& [key, g] : groups) {
    table.rows.push_back({key.first, key.second, median(g.cm), median(g.deg), median(g.against_all), geometric_mean(g.sigma_ratio),
                          mean(g.squares), g.calibrated, g.runs});
    if (key.second == everything) continue;
    rmse_lines[key.first].x.push_back(key.second);
    rmse_lines[key.first].y.push_back(median(g.against_all));
    sigma_lines[key.first].x.push_back(key.second);
    sigma_lines[key.first].y.push_back(geometric_mean(g.sigma_ratio));
  }
  for (auto& [name, line] : rmse_lines) {
    line.name = sigma_lines[name].name = name;
    rmse.series.push_back(line);
    sigma.series.push_back(sigma_lines[name]);
  }
  out.tables = {table};
  out.figures = {rmse, sigma};
  return out;
}

}  // namespace host::experiments
