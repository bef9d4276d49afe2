// The paper's table III: the same device calibrated from several sessions, each by itself.
#include <algorithm>
#include <map>

#include "experiments/methods.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"

namespace host::experiments {

std::vector<Cell> repeatability_cells(const StudyOptions& options) {
  std::vector<Cell> cells;
  for (const Dataset& d : datasets()) {
    if (!d.multi_session) continue;  // the AR/VR use case, as the paper has it
    for (int session = 0; session < (options.quick ? 3 : d.sessions); ++session) {
      for (const Method& m : methods()) {
        if (std::string(m.name) == "initial" || m.odometry != Odometry::held) continue;
        cells.push_back({std::string(d.name) + "_session" + std::to_string(session) + "_" + m.name,
                         {{"dataset", d.name},
                          {"session", session},
                          {"session_s", d.session_s},
                          {"method", m.name},
                          {"seed", options.seed}}});
      }
    }
  }
  return cells;
}

Json repeatability_run(const Json& parameters) {
  const Dataset& dataset = dataset_named(parameters.at("dataset"));
  const std::uint64_t seed = parameters.at("seed");
  const int session = parameters.at("session");
  const std::vector<SimulationResult> sessions = {simulate_session(dataset, seed, session, parameters.at("session_s"))};
  MethodOptions options;
  options.seed = seed + static_cast<std::uint64_t>(session);
  const CoreResult result = calibrate(parameters.at("method"), sessions, options).back().result;
  return {{"status", result.status}, {"parameters", parameters_json(result, sessions.front().truth)}};
}

namespace {

struct MethodRecord {
  std::string unit;
  double truth = 0;
  std::vector<double> value, sigma;
};

/// Of all sessions, in the order of the calibration vector.
struct MethodRecords {
  std::vector<std::string> names;
  std::map<std::pair<std::string, std::string>, MethodRecord> of;  ///< by parameter and method
};

MethodRecords method_records(const std::vector<CellResult>& cells) {
  MethodRecords out;
  for (const CellResult& c : cells) {
    for (const Json& p : c.result.at("parameters")) {
      const std::string name = p.at("name");
      if (std::find(out.names.begin(), out.names.end(), name) == out.names.end()) out.names.push_back(name);
      MethodRecord& r = out.of[{name, c.parameters.at("method")}];
      r.unit = p.at("unit");
      r.truth = p.at("truth");
      r.value.push_back(p.at("value"));
      r.sigma.push_back(p.at("sigma"));
    }
  }
  return out;
}

/// What one method's answers scatter by.
struct Scatter {
  std::vector<double> against_all, against_sigma, squares;
  Series bars;
};

/// Adds the method's rows to `table`.
Scatter scatter_of(const MethodRecords& records, const std::string& method, Table* table) {
  Scatter out;
  out.bars.name = method;
  for (const std::string& name : records.names) {
    const auto it = records.of.find({name, method});
    if (it == records.of.end()) continue;
    const MethodRecord& r = it->second;
    const double scatter = deviation(r.value), ratio = scatter / deviation(records.of.at({name, "all"}).value);
    table->rows.push_back({name, r.unit, method, r.truth, mean(r.value), scatter, mean(r.sigma),
                           mean(r.value) - r.truth, ratio, r.value.size()});
    for (std::size_t i = 0; i < r.value.size(); ++i)
      out.squares.push_back(std::pow((r.value[i] - r.truth) / r.sigma[i], 2));
    out.against_all.push_back(ratio);
    out.against_sigma.push_back(scatter / mean(r.sigma));
    out.bars.x.push_back(name);
    out.bars.y.push_back(ratio);
  }
  return out;
}

}  // namespace

Findings repeatability_gather(const std::vector<CellResult>& cells) {
  const MethodRecords records = method_records(cells);
  Findings out;
  Table table{"Parameters over sessions",
              "One device, each session calibrated by itself from the data sheet's values.",
              {{"parameter", ""},
               {"unit", ""},
               {"method", ""},
               {"truth", "unit"},
               {"mean", "unit"},
               {"scatter", "unit"},
               {"stated sigma, mean", "unit"},
               {"mean error", "unit"},
               {"scatter against all", "-"},
               {"sessions", "-"}},
              {}};
  Table summary{"Methods",
                "Scatter: standard deviation over the sessions, against that of `all`, geometric mean over the "
                "parameters. Mean (error/sigma)^2 over parameters and sessions: 1 is honest.",
                {{"method", ""},
                 {"scatter against all", "-"},
                 {"scatter against stated sigma", "-"},
                 {"mean (error/sigma)^2", "-"}},
                {}};
  Figure figure{"Scatter against that of all segments", "bars", "parameter", "ratio [-]", true, {}};
  for (const Method& m : methods()) {
    const Scatter of = scatter_of(records, m.name, &table);
    if (of.bars.x.empty()) continue;
    summary.rows.push_back(
        {m.name, geometric_mean(of.against_all), geometric_mean(of.against_sigma), mean(of.squares)});
    figure.series.push_back(of.bars);
  }
  out.tables = {table, summary};
  out.figures = {figure};
  return out;
}

}  // namespace host::experiments
