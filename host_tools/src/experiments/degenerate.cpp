// Motions that cannot tell everything: is what is released right within
// its sigma, and is what the motion cannot tell held back and named?
#include <algorithm>
#include <map>
#include <set>

#include "experiments/datasets.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"
#include "replay/replay.h"
#include "replay/words.h"

namespace host::experiments {
namespace {

constexpr double degenerate_session_s = 40;
constexpr double largest_mean_square = 1.5;

/// What follows from the motion alone: these parameters cannot be told, whatever the noise.
struct Motion {
  const char* scenario;
  std::vector<std::string> blind;
};

const std::vector<Motion>& motions() {
  static const std::vector<Motion> all = {
      // Neither turning nor accelerating: nothing of the IMU but its mean, and no lever arm.
      {"line",
       {"gyro.sx", "gyro.sy", "gyro.sz", "gyro.mx", "gyro.my", "gyro.mz", "accel.sx", "accel.sy", "accel.sz",
        "accel.mx", "accel.my", "accel.mz", "cam0.p_CI.x", "cam0.p_CI.y", "cam0.p_CI.z"}},
      // Turning about the IMU: the camera, which sits beside it, moves, but nothing gives the size of that motion.
      {"rotation", {"cam0.p_CI.x"}},
      // Turning about z alone: what belongs to rates about x and y, to
      // the acceleration along z, and the lever arm along the axis.
      {"planar", {"cam0.p_CI.y", "gyro.sx", "gyro.sy", "gyro.mx", "accel.sz"}},
      {"still", {}},
  };
  return all;
}

/// Names with at least a fifth of the weight of a direction that is named as not excited.
std::set<std::string> named_directions(const ReplayResult& replayed) {
  std::set<std::string> out;
  const auto names = parameter_names(replayed.calibration);
  for (const CoreDirection& d : replayed.result.unobservable) {
    for (const auto& [name, weight] : main_weights(d, names)) out.insert(name);
  }
  return out;
}

/// One parameter of one motion over all seeds.
struct Record {
  int observed = 0, weak = 0, fixed = 0, not_named = 0, moved_though_fixed = 0;
  double squares = 0, largest = 0;
  std::string worst_seed;
  int released() const { return observed + weak; }
  double mean_square() const { return released() ? squares / released() : 0; }
};

void add(Record& r, const Json& p, const std::string& seed, bool named) {
  const double value = p.at("value"), sigma = p.at("sigma");
  r.not_named += named ? 0 : 1;
  if (p.at("verdict") == "fixed") {
    ++r.fixed;
    r.moved_though_fixed += std::abs(value - p.at("initial").get<double>()) > 1e-5 * (1 + std::abs(value)) ? 1 : 0;
    return;
  }
  ++(p.at("verdict") == "observed" ? r.observed : r.weak);
  const double error = (value - p.at("truth").get<double>()) / sigma;
  r.squares += error * error;
  if (std::abs(error) <= r.largest) return;
  r.largest = std::abs(error);
  r.worst_seed = seed;
}

/// All seeds of one motion.
struct MotionRecord {
  std::vector<std::string> names;  ///< of parameters, as they come
  std::map<std::string, Record> parameters;
  std::map<std::string, int> statuses;
};

std::map<std::string, MotionRecord> records_of(const std::vector<CellResult>& cells) {
  std::map<std::string, MotionRecord> out;
  for (const CellResult& c : cells) {
    MotionRecord& motion = out[c.parameters.at("scenario").get<std::string>()];
    ++motion.statuses[c.result.at("status").get<std::string>()];
    const auto named = c.result.at("named").get<std::set<std::string>>();
    for (const Json& p : c.result.at("parameters")) {
      const std::string name = p.at("name");
      if (!motion.parameters.count(name)) motion.names.push_back(name);
      add(motion.parameters[name], p, c.parameters.at("seed").dump(), named.count(name) > 0);
    }
  }
  return out;
}

/// What the limits are about, over the parameters of one motion.
struct Summary {
  double largest = 0;  ///< mean (error/sigma)^2
  std::string of;
  int released = 0, unnamed = 0, moved = 0;

  void add(const std::string& name, const Record& r, bool blind) {
    if (blind) released += r.released();
    if (blind) unnamed += r.not_named;
    moved += r.moved_though_fixed;
    // The mean of a few squares says nothing: at least ten seeds must have released it.
    if (r.released() < 10 || r.mean_square() <= largest) return;
    largest = r.mean_square();
    of = name;
  }

  void put_limits(const std::string& scenario, std::vector<Limit>* limits) const {
    limits->push_back({"largest mean (error/sigma)^2, " + scenario, largest, largest_mean_square, "-", false});
    limits->push_back({"blind parameters released, " + scenario, static_cast<double>(released), 0, "-", false});
    limits->push_back({"blind parameters not named, " + scenario, static_cast<double>(unnamed), 0, "-", false});
    limits->push_back({"fixed parameters that moved, " + scenario, static_cast<double>(moved), 0, "-", false});
  }
};

}  // namespace

std::vector<Cell> degenerate_cells(const StudyOptions& options) {
  std::vector<Cell> cells;
  // The mean of 20 squares scatters by 0.32, that of 100 by 0.14: only the full study can tell 1.5 from 1.
  const int seeds = options.quick ? 20 : 100;
  for (const Motion& m : motions()) {
    for (int i = 0; i < seeds; ++i) {
      const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
      cells.push_back({std::string(m.scenario) + "_seed" + std::to_string(seed),
                       {{"scenario", m.scenario}, {"seconds", degenerate_session_s}, {"seed", seed}}});
    }
  }
  return cells;
}

Json degenerate_run(const Json& parameters) {
  const SimulationResult session = simulate_cell(parameters);
  ReplayOptions options;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  const ReplayResult replayed = replay({session.recording}, options);
  Json words = Json::array();
  const auto names = parameter_names(replayed.calibration);
  for (const CoreDirection& d : replayed.result.unobservable) words.push_back(in_words(d, names));
  return {{"status", replayed.result.status},
          {"segments_kept", replayed.kept.size()},
          {"directions", words},
          {"named", named_directions(replayed)},
          {"parameters", parameters_json(replayed.result, session.truth)}};
}

Findings degenerate_gather(const std::vector<CellResult>& cells) {
  Findings out;
  Table table{"Parameters",
              "blind: the motion alone cannot tell it. Released: observed or weak. Errors are of released values.",
              {{"motion", ""},
               {"parameter", ""},
               {"blind", ""},
               {"observed", "-"},
               {"weak", "-"},
               {"fixed", "-"},
               {"not named", "-"},
               {"mean (error/sigma)^2 of released", "-"},
               {"largest error", "sigma"},
               {"its seed", "-"}},
              {}};
  Table motions_table{"Motions",
                      "",
                      {{"motion", ""},
                       {"calibrated", "-"},
                       {"insufficient", "-"},
                       {"failed", "-"},
                       {"largest mean (error/sigma)^2", "-"},
                       {"of", ""},
                       {"blind parameters released", "-"},
                       {"blind and not named", "-"}},
                      {}};
  Figure figure{"Mean (error/sigma)^2 of what is released", "bars", "parameter", "mean (error/sigma)^2 [-]", false, {}};
  std::map<std::string, MotionRecord> records = records_of(cells);
  for (const Motion& m : motions()) {
    if (!records.count(m.scenario)) continue;
    MotionRecord& motion = records[m.scenario];
    Summary summary;
    Series bars{m.scenario, {}, {}};
    for (const std::string& name : motion.names) {
      const Record& r = motion.parameters[name];
      const bool blind = std::find(m.blind.begin(), m.blind.end(), name) != m.blind.end();
      summary.add(name, r, blind);
      table.rows.push_back({m.scenario, name, blind ? "blind" : "", r.observed, r.weak, r.fixed, r.not_named,
                            r.released() ? Json(r.mean_square()) : Json(nullptr), r.largest, r.worst_seed});
      if (!r.released()) continue;
      bars.x.push_back(name);
      bars.y.push_back(r.mean_square());
    }
    auto& s = motion.statuses;
    motions_table.rows.push_back({m.scenario, s["calibrated"], s["insufficient"], s["failed"], summary.largest,
                                  summary.of, summary.released, summary.unnamed});
    if (!bars.x.empty()) figure.series.push_back(bars);
    summary.put_limits(m.scenario, &out.limits);
  }
  out.tables = {table, motions_table};
  out.figures = {figure};
  return out;
}

}  // namespace host::experiments
