// The paper's figure 9: how many segments are enough?
#include <map>

#include "experiments/methods.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"

namespace host::experiments {
namespace {

constexpr int largest_size = 15;  // what profile mobile holds
constexpr int everything = 0;     // stands for all segments

/// All sessions of one use case with one size of the database.
struct Group {
  std::vector<double> cm, deg, against_all, sigma_ratio, squares;
  int calibrated = 0, runs = 0;

  /// `base`: what all segments of the same session give.
  void add(const Json& result, const Json& base) {
    for (std::size_t i = 0; i < result.at("position_cm").size(); ++i) {
      cm.push_back(result.at("position_cm").at(i));
      deg.push_back(result.at("attitude_deg").at(i));
      against_all.push_back(cm.back() / base.at("position_cm").at(i).get<double>());
    }
    const Json &a = result.at("parameters"), &b = base.at("parameters");
    for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
      const double sigma = a[i].at("sigma");
      sigma_ratio.push_back(sigma / b[i].at("sigma").get<double>());
      if (a[i].at("verdict") == "fixed") continue;
      const double error = (a[i].at("value").get<double>() - a[i].at("truth").get<double>()) / sigma;
      squares.push_back(error * error);
    }
    ++runs;
    calibrated += result.at("status") == "calibrated";
  }
};

/// By use case and size.
std::map<std::pair<std::string, int>, Group> groups_of(const std::vector<CellResult>& cells) {
  const auto place = [](const CellResult& c) {
    return c.parameters.at("dataset").get<std::string>() + c.parameters.at("session").dump();
  };
  std::map<std::string, Json> all;  // by dataset and session
  for (const CellResult& c : cells) {
    if (c.parameters.at("segments") == everything) all[place(c)] = c.result;
  }
  std::map<std::pair<std::string, int>, Group> groups;
  for (const CellResult& c : cells) {
    const std::string scenario = dataset_named(c.parameters.at("dataset")).scenario;
    groups[{scenario, c.parameters.at("segments")}].add(c.result, all.at(place(c)));
  }
  return groups;
}

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
                         {{"dataset", d.name},
                          {"session", session},
                          {"segments", size},
                          {"session_s", d.session_s},
                          {"evaluations", options.quick ? 3 : 15},
                          {"evaluation_s", options.quick ? 60 : 114},
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
  const std::vector<SimulationResult> sessions = {
      simulate_session(dataset, seed, parameters.at("session"), parameters.at("session_s"))};
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
  Findings out;
  Table table{"Database size",
              "A-optimality, segments of 4 s, each session by itself. Size 0: all segments, up to 64. Ratios against "
              "all: position, median over the same pairs; sigmas, geometric mean over parameters and sessions.",
              {{"use case", ""},
               {"segments", "-"},
               {"position", "cm"},
               {"attitude", "deg"},
               {"position against all", "-"},
               {"sigmas against all", "-"},
               {"mean (error/sigma)^2", "-"},
               {"calibrated", "-"},
               {"sessions", "-"}},
              {}};
  Figure rmse{"Position RMSE", "lines", "segments", "RMSE against all [-]", true, {}};
  Figure sigma{"Sigmas", "lines", "segments", "sigma against all [-]", true, {}};
  for (const auto& [key, g] : groups_of(cells)) {  // in the order of use cases
    const double position = median(g.against_all), sigmas = geometric_mean(g.sigma_ratio);
    table.rows.push_back(
        {key.first, key.second, median(g.cm), median(g.deg), position, sigmas, mean(g.squares), g.calibrated, g.runs});
    if (key.second == everything) continue;
    for (Figure* figure : {&rmse, &sigma}) {
      if (figure->series.empty() || figure->series.back().name != key.first)
        figure->series.push_back({key.first, {}, {}});
      figure->series.back().x.push_back(key.second);
      figure->series.back().y.push_back(figure == &rmse ? position : sigmas);
    }
  }
  out.tables = {table};
  out.figures = {rmse, sigma};
  return out;
}

}  // namespace host::experiments
