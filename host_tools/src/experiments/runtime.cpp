// The paper's table IV: times on the machine that runs this. Cells run one at a time; other load on the machine shows.
#include <map>

#include "experiments/datasets.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"
#include "replay/replay.h"

namespace host::experiments {

std::vector<Cell> runtime_cells(const StudyOptions& options) {
  std::vector<Cell> cells;
  for (const Dataset& d : datasets()) {
    for (const char* profile : {"mcu", "mobile", "host"}) {
      for (int repeat = 0; repeat < (options.quick ? 1 : 3); ++repeat) {
        cells.push_back({std::string(d.name) + "_" + profile + "_" + std::to_string(repeat),
                         {{"dataset", d.name},
                          {"profile", profile},
                          {"segments", std::string(profile) == "host" ? 64 : 8},
                          {"session_s", d.session_s},
                          {"repeat", repeat},
                          {"seed", options.seed}}});
      }
    }
  }
  return cells;
}

Json runtime_run(const Json& parameters) {
  const Dataset& dataset = dataset_named(parameters.at("dataset"));
  const SimulationResult session = simulate_session(dataset, parameters.at("seed"), 0, parameters.at("session_s"));
  ReplayOptions options;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  options.core.segments = parameters.at("segments");
  options.profile = parameters.at("profile");
  const ReplayResult r = replay({session.recording}, options);
  return {{"vio_ms_median", r.timing.vio_ms_median},     {"vio_ms_p95", r.timing.vio_ms_p95},
          {"score_ms_median", r.timing.score_ms_median}, {"calibrate_ms", r.timing.calibrate_ms},
          {"iterations", r.result.iterations},           {"segments", r.result.segments}};
}

Findings runtime_gather(const std::vector<CellResult>& cells) {
  struct Group {
    std::vector<double> vio, p95, score, calibrate, iterations, segments;
  };
  std::map<std::pair<std::string, std::string>, Group> groups;
  for (const CellResult& c : cells) {
    Group& g = groups[{dataset_named(c.parameters.at("dataset")).scenario, c.parameters.at("profile")}];
    g.vio.push_back(c.result.at("vio_ms_median"));
    g.p95.push_back(c.result.at("vio_ms_p95"));
    g.score.push_back(c.result.at("score_ms_median"));
    g.calibrate.push_back(c.result.at("calibrate_ms"));
    g.iterations.push_back(c.result.at("iterations"));
    g.segments.push_back(c.result.at("segments"));
  }
  Findings out;
  Table table{"Times",
              "Medians over sessions and repeats, one thread. mcu and mobile keep 8 segments, host keeps all, up to "
              "64. The paper's table IV, in ms: each image 3, each segment 156, each calibration 12050, batch 27028.",
              {{"use case", ""},
               {"profile", ""},
               {"each image", "ms"},
               {"each image, 95 %", "ms"},
               {"each segment", "ms"},
               {"calibration", "ms"},
               {"iterations", "-"},
               {"segments", "-"}},
              {}};
  for (const auto& [key, g] : groups) {
    table.rows.push_back({key.first, key.second, median(g.vio), median(g.p95), median(g.score), median(g.calibrate),
                          median(g.iterations), median(g.segments)});
  }
  out.tables = {table};
  return out;
}

}  // namespace host::experiments
