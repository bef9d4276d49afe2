// The paper's table II: how well does odometry do with the calibration that each method gives?
#include <algorithm>
#include <map>

#include "experiments/methods.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"

namespace host::experiments {
namespace {

constexpr double most_ratio = 1.10;        // of the RMSE with all segments
constexpr double most_set_d_ratio = 1.03;  // of the best of A, D and E
constexpr const char* reference = "all";

struct Row {
  std::vector<double> position_cm, attitude_deg;
};

void append(std::vector<double>& to, const Json& from) {
  for (const double v : from) to.push_back(v);
}

}  // namespace

std::vector<Cell> accuracy_cells(const StudyOptions& options) {
  std::vector<Cell> cells;
  for (const Dataset& d : datasets()) {
    for (const Method& m : methods()) {
      cells.push_back({std::string(d.name) + "_" + m.name,
                       {{"dataset", d.name},
                        {"method", m.name},
                        {"sessions", options.quick ? 2 : d.sessions},
                        {"session_s", d.session_s},
                        {"evaluations", options.quick ? 6 : 15},
                        {"evaluation_s", options.quick ? 60 : 114},
                        {"seed", options.seed}}});
    }
  }
  return cells;
}

/// Calibrates after each session and evaluates each of these calibrations.
Json accuracy_run(const Json& parameters) {
  const Dataset& dataset = dataset_named(parameters.at("dataset"));
  const std::uint64_t seed = parameters.at("seed");
  std::vector<SimulationResult> sessions;
  for (int i = 0; i < parameters.at("sessions").get<int>(); ++i) {
    sessions.push_back(simulate_session(dataset, seed, i, parameters.at("session_s")));
  }
  MethodOptions options;
  options.multi_session = dataset.multi_session;
  options.seed = seed;
  const auto calibrations = calibrate(parameters.at("method"), sessions, options);
  const Evaluation evaluation(seed, parameters.at("evaluations"), parameters.at("evaluation_s"));
  Json after = Json::array();
  for (const SessionCalibration& c : calibrations) {
    Json one = evaluation(c.calibration, method_named(parameters.at("method")).odometry);
    one["status"] = c.result.status;
    one["segments"] = c.result.segments;
    after.push_back(one);
  }
  return {{"after_session", after}};
}

namespace {

void add_limits(const std::string& dataset, const std::map<std::string, double>& ratio, Findings* out) {
  for (const char* name : {"A", "D", "E", "set_d"}) {
    if (ratio.count(name))
      out->limits.push_back({std::string(name) + " against all, " + dataset, ratio.at(name), most_ratio, "-", false});
  }
  if (!ratio.count("set_d")) return;
  const double best = std::min({ratio.at("A"), ratio.at("D"), ratio.at("E")});
  out->limits.push_back(
      {"set_d against the best of A, D, E, " + dataset, ratio.at("set_d") / best, most_set_d_ratio, "-", false});
}

}  // namespace

Findings accuracy_gather(const std::vector<CellResult>& cells) {
  std::map<std::string, std::map<std::string, Row>> rows;
  for (const CellResult& c : cells) {
    Row& row = rows[c.parameters.at("dataset")][c.parameters.at("method")];
    for (const Json& one : c.result.at("after_session")) {
      append(row.position_cm, one.at("position_cm"));
      append(row.attitude_deg, one.at("attitude_deg"));
    }
  }
  Findings out;
  Table table{"Odometry with each calibration",
              "RMSE against the simulated truth from 15 s on after alignment of yaw and position: median and standard "
              "deviation over all evaluation sessions and the calibrations after each session. Ratio: median over the "
              "same pairs, to `all`.",
              {{"dataset", ""},
               {"method", ""},
               {"position", "cm"},
               {"+-", "cm"},
               {"attitude", "deg"},
               {"+-", "deg"},
               {"position against all", "-"},
               {"attitude against all", "-"},
               {"runs", "-"}},
              {}};
  Figure figure{"Position RMSE", "boxes", "dataset", "RMSE [cm]", true, {}};
  std::map<std::string, Series> boxes;
  for (const Dataset& d : datasets()) {
    const auto& methods_of = rows[d.name];
    const Row& base = methods_of.at(reference);
    std::map<std::string, double> ratio;
    for (const Method& m : methods()) {
      const Row& r = methods_of.at(m.name);
      ratio[m.name] = median_ratio(r.position_cm, base.position_cm);
      table.rows.push_back({d.name, m.name, median(r.position_cm), deviation(r.position_cm), median(r.attitude_deg),
                            deviation(r.attitude_deg), ratio[m.name], median_ratio(r.attitude_deg, base.attitude_deg),
                            r.position_cm.size()});
      for (const double v : r.position_cm) {
        boxes[m.name].x.push_back(d.name);
        boxes[m.name].y.push_back(v);
      }
    }
    add_limits(d.name, ratio, &out);
  }
  for (const Method& m : methods()) {
    boxes[m.name].name = m.name;
    figure.series.push_back(boxes[m.name]);
  }
  out.tables = {table};
  out.figures = {figure};
  return out;
}

}  // namespace host::experiments
