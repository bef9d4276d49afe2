// The paper's figure 7: a database that is kept over sessions against one that starts anew each session.
#include <algorithm>
#include <map>

#include "experiments/methods.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"

namespace host::experiments {
namespace {

constexpr double most_ratio_after_two = 1.15;

/// What is compared; `all` is told two ways, as the paper does and of everything seen.
struct Strategy {
  const char *name, *method;
  bool multi_session;
};
constexpr Strategy strategies[] = {
    {"multi", "A", true}, {"single", "A", false}, {"all_of_session", "all", false}, {"all_so_far", "all", true}};

/// Middle ratio of the sigmas of two calibrations.
double sigma_ratio(const Json& a, const Json& b) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) ratios.push_back(a[i].get<double>() / b[i].get<double>());
  return geometric_mean(ratios);
}

/// Dataset and seed -> strategy -> what follows each session.
using Runs = std::map<std::pair<std::string, std::string>, std::map<std::string, Json>>;

/// One strategy after one session, over all runs.
struct After {
  std::vector<double> cm, deg, so_far, of_session, sigma_so_far, sigma_of_session;

  After(const Runs& runs, const char* strategy, std::size_t session) {
    for (const auto& [key, by_strategy] : runs) {
      add(by_strategy.at(strategy).at(session), by_strategy.at("all_so_far").at(session),
          by_strategy.at("all_of_session").at(session));
    }
  }

  void add(const Json& one, const Json& a, const Json& b) {
    for (std::size_t i = 0; i < one.at("position_cm").size(); ++i) {
      const double error = one.at("position_cm").at(i);
      cm.push_back(error);
      deg.push_back(one.at("attitude_deg").at(i));
      so_far.push_back(error / a.at("position_cm").at(i).get<double>());
      of_session.push_back(error / b.at("position_cm").at(i).get<double>());
    }
    sigma_so_far.push_back(sigma_ratio(one.at("sigma"), a.at("sigma")));
    sigma_of_session.push_back(sigma_ratio(one.at("sigma"), b.at("sigma")));
  }
};

void put_limits(const After& after_two, std::vector<Limit>* limits) {
  limits->push_back({"multi after two sessions, position against all_so_far", median(after_two.so_far),
                     most_ratio_after_two, "-", false});
  limits->push_back({"multi after two sessions, position against all_of_session", median(after_two.of_session),
                     most_ratio_after_two, "-", false});
}

}  // namespace

std::vector<Cell> sessions_cells(const StudyOptions& options) {
  std::vector<Cell> cells;
  for (const Dataset& d : datasets()) {
    if (!d.multi_session) continue;
    for (int i = 0; i < (options.quick ? 1 : 4); ++i) {
      const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
      for (const Strategy& s : strategies) {
        cells.push_back({std::string(d.name) + "_seed" + std::to_string(seed) + "_" + s.name,
                         {{"dataset", d.name},
                          {"strategy", s.name},
                          {"sessions", d.sessions},
                          {"session_s", d.session_s},
                          {"evaluations", options.quick ? 3 : 15},
                          {"evaluation_s", options.quick ? 60 : 114},
                          {"seed", seed}}});
      }
    }
  }
  return cells;
}

Json sessions_run(const Json& parameters) {
  const Dataset& dataset = dataset_named(parameters.at("dataset"));
  const std::uint64_t seed = parameters.at("seed");
  const std::string name = parameters.at("strategy");
  const Strategy* strategy =
      std::find_if(std::begin(strategies), std::end(strategies), [&name](const Strategy& s) { return name == s.name; });
  std::vector<SimulationResult> sessions;
  for (int i = 0; i < parameters.at("sessions").get<int>(); ++i) {
    sessions.push_back(simulate_session(dataset, seed, i, parameters.at("session_s")));
  }
  MethodOptions options;
  options.multi_session = strategy->multi_session;
  const Evaluation evaluation(seed, parameters.at("evaluations"), parameters.at("evaluation_s"));
  Json after = Json::array();
  for (const SessionCalibration& c : calibrate(strategy->method, sessions, options)) {
    Json one = evaluation(c.calibration), sigma = Json::array();
    for (const CoreParameter& p : c.result.parameters) sigma.push_back(p.sigma);
    one["sigma"] = sigma;
    one["status"] = c.result.status;
    after.push_back(one);
  }
  return {{"after_session", after}};
}

Findings sessions_gather(const std::vector<CellResult>& cells) {
  Runs runs;
  std::size_t sessions = 0;
  for (const CellResult& c : cells) {
    const Json& after = c.result.at("after_session");
    runs[{c.parameters.at("dataset"), c.parameters.at("seed").dump()}][c.parameters.at("strategy")] = after;
    sessions = std::max(sessions, after.size());
  }
  Findings out;
  Table table{"After each session",
              "RMSE: median over evaluation sessions, devices and rooms. Ratios: medians over the same pairs; sigmas: "
              "geometric mean over the parameters. `all_of_session`: every segment of that session alone, the paper's "
              "batch; `all_so_far`: every segment of all sessions until then, the best 64 where there are more.",
              {{"session", "-"},
               {"strategy", ""},
               {"position", "cm"},
               {"attitude", "deg"},
               {"position against all_so_far", "-"},
               {"position against all_of_session", "-"},
               {"sigmas against all_so_far", "-"},
               {"sigmas against all_of_session", "-"}},
              {}};
  Figure rmse{"Position RMSE after each session", "lines", "session", "RMSE [cm]", false, {}};
  Figure sigma{"Sigmas against all segments so far", "lines", "session", "ratio [-]", false, {}};
  for (const Strategy& s : strategies) {
    Series line{s.name, {}, {}}, sigma_line{s.name, {}, {}};
    for (std::size_t k = 0; k < sessions; ++k) {
      const After after(runs, s.name, k);
      table.rows.push_back({k + 1, s.name, median(after.cm), median(after.deg), median(after.so_far),
                            median(after.of_session), median(after.sigma_so_far), median(after.sigma_of_session)});
      line.x.push_back(k + 1);
      line.y.push_back(median(after.cm));
      sigma_line.x.push_back(k + 1);
      sigma_line.y.push_back(median(after.sigma_so_far));
      if (k == 1 && std::string(s.name) == "multi") put_limits(after, &out.limits);
    }
    rmse.series.push_back(line);
    sigma.series.push_back(sigma_line);
  }
  out.tables = {table};
  out.figures = {rmse, sigma};
  return out;
}

}  // namespace host::experiments
