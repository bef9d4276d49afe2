// Faults in the data: is each reported by name, and is what is then called calibrated right? Every recording goes the
// way of `segcal replay`: clocks compared, calibrated, reviewed.
#include <cmath>
#include <ctime>
#include <map>
#include <set>

#include "experiments/experiment.h"
#include "experiments/registry.h"
#include "replay/model_file.h"
#include "replay/replay.h"
#include "simulate/device.h"
#include "simulate/effect_names.h"
#include "simulate/fault_kinds.h"
#include "simulate/simulate.h"

namespace host::experiments {
namespace {

using sim::FaultKind, sim::fault_kind, sim::fault_kinds;

constexpr double fault_session_s = 40;

/// Counters that say of a fault; the others count work.
const std::vector<std::string>& fault_counters() {
  static const std::vector<std::string> names = {
      "imu_stamps_back",   "imu_gaps",        "imu_not_finite",    "imu_saturated",    "imu_stamps_far",
      "frame_stamps_back", "frames_dropped",  "frames_few_tracks", "frame_stamps_far", "points_not_finite",
      "points_repeated",   "filter_restarts", "clock_restarts",    "segments_outdated"};
  return names;
}

SimulationResult session_of(const Json& p, const FaultKind& kind) {
  SimulationOptions options;
  options.seconds = p.at("seconds");
  options.seed = p.at("seed");
  if (!kind.effect.empty()) options.effects.push_back(sim::parse_effect(kind.effect));
  SimulationResult session = simulate(options);
  kind.spoil(session.recording, options.seed);
  return session;
}

/// What may be called right: the device as it was and, where something moved, as it has been since.
std::vector<Calibration> truths_of(const SimulationResult& session, const Json& p, const FaultKind& kind) {
  std::vector<Calibration> out = {session.truth};
  const std::string name = kind.name;
  if (name == "half_resolution") out[0].cameras[0].intrinsics *= 0.5;
  if (name == "principal_point_moves") {
    out.push_back(session.truth);
    out[1].cameras[0].intrinsics[2] += 4;
  }
  if (kind.effect.empty()) return out;
  out.push_back(session.truth);
  const double end = p.at("seconds").get<double>();
  sim::parse_effect(kind.effect)->on_camera_calibration(end, 0, out[1].cameras[0]);
  return out;
}

struct Largest {
  double sigmas = 0;
  std::string of;
};

/// Of the released values against one truth.
Largest largest_error(const CoreResult& result, const Calibration& truth) {
  std::map<std::string, double> values;
  for (const sim::NamedParameter& p : sim::named_parameters(truth, true)) values[p.name] = p.value;
  Largest out;
  for (const CoreParameter& p : result.parameters) {
    if (p.verdict == "fixed" || !values.count(p.name)) continue;
    const double z = std::abs(p.value - values[p.name]) / p.sigma;
    if (z > out.sigmas || std::isnan(z)) out = {z, p.name};
  }
  return out;
}

Largest smallest_of_largest(const CoreResult& result, const std::vector<Calibration>& truths) {
  Largest out = largest_error(result, truths.front());
  for (const Calibration& truth : truths) {
    const Largest other = largest_error(result, truth);
    if (other.sigmas < out.sigmas) out = other;
  }
  return out;
}

/// As `segcal replay` does without options.
ReplayResult replay_as_user(SimulationResult* session, bool keep_clock) {
  ReplayOptions options;
  options.core.calibration = session->nominal;
  options.core.noise = session->recording.imu.noise;
  options.core.has_temperature = session->recording.imu.has_temperature;
  options.review = true;
  EffectChoice effects;
  if (!keep_clock) {
    options.clocks.push_back(search_clock(session->recording, session->nominal.cameras.front(), 0));
    const ClockSearch& found = options.clocks.front();
    if (found.differs_from(0)) {
      shift_frames(found.offset_s, &session->recording);
      effects.enable("time_offset");
    }
  }
  effects.apply(&options.core);
  return replay({session->recording}, options);
}

Json said(const ReplayResult& r) {
  Json counters = Json::object(), suspects = Json::array();
  for (const auto& [name, count] : r.counters)
    for (const std::string& fault : fault_counters())
      if (name == fault && count > 0) counters[name] = count;
  for (const Suspect& s : r.health.suspects) suspects.push_back(s.name);
  Json clock;
  if (!r.clocks.empty() && r.clocks.front().differs_from(0)) clock = "time_offset: " + r.clocks.front().words;
  return {{"counters", counters}, {"suspects", suspects}, {"clock", clock}, {"cause", r.cause}};
}

/// What a run named: counters that stand above those of the clean recording, suspects, the clock's offset, the cause.
std::set<std::string> named(const Json& result, const Json& clean) {
  std::set<std::string> out;
  for (const auto& [name, count] : result.at("said").at("counters").items())
    if (count.get<double>() > (clean.contains(name) ? clean.at(name).get<double>() : 0)) out.insert(name);
  for (const Json& s : result.at("said").at("suspects")) out.insert(s.get<std::string>());
  if (result.at("said").at("clock").is_string()) out.insert("time_offset");
  return out;
}

bool reported(const FaultKind& kind, const std::set<std::string>& names, const std::string& cause) {
  if (kind.names.empty()) return true;
  for (const std::string& part : kind.names) {
    if (cause.find(part) != std::string::npos) return true;
    for (const std::string& name : names)
      if (name.find(part) != std::string::npos) return true;
  }
  return false;
}

struct KindRow {
  int n = 0, calibrated = 0, wrong = 0, reported = 0;
  Largest largest;
  std::map<std::string, int> names;
  std::string cause;
  double seconds = 0;
};

std::string joined(const std::map<std::string, int>& names, int n) {
  std::string out;
  for (const auto& [name, count] : names)
    out += (out.empty() ? "" : ", ") + name + (count < n ? " (" + std::to_string(count) + ")" : "");
  return out;
}

}  // namespace

std::vector<Cell> faults_cells(const StudyOptions& options) {
  const int seeds = options.seeds > 0 ? options.seeds : options.quick ? 2 : 20;
  std::vector<Cell> cells;
  for (int i = 0; i < seeds; ++i) {
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
    for (const FaultKind& kind : fault_kinds())
      cells.push_back({std::string(kind.name) + "_seed" + std::to_string(seed),
                       {{"kind", kind.name}, {"seconds", fault_session_s}, {"seed", seed}}});
  }
  return cells;
}

Json faults_run(const Json& parameters) {
  const FaultKind& kind = fault_kind(parameters.at("kind"));
  SimulationResult session = session_of(parameters, kind);
  const std::vector<Calibration> truths = truths_of(session, parameters, kind);
  const std::clock_t began = std::clock();
  const ReplayResult r = replay_as_user(&session, kind.keep_clock);
  const double seconds = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  const Largest largest = smallest_of_largest(r.result, truths);
  const bool calibrated = r.calibrated && r.result.status == "calibrated";
  return {{"status", calibrated                        ? "calibrated"
                     : r.result.status == "calibrated" ? "insufficient"
                                                       : r.result.status},
          {"largest", largest.sigmas},
          {"largest_of", largest.of},
          {"chi2_per_dof", r.result.dof > 0 ? r.result.chi2 / r.result.dof : 0.0},
          {"segments", r.result.segments},
          {"said", said(r)},
          {"seconds", seconds}};
}

namespace {

/// Adds a run to its kind's row, and to `wrong` if it is. `clean`: counters of the recording without a fault.
void add_run(const CellResult& c, const Json& clean, KindRow* row, Table* wrong) {
  const FaultKind& kind = fault_kind(c.parameters.at("kind"));
  const std::set<std::string> names = named(c.result, clean);
  const std::string cause = c.result.at("said").at("cause");
  const double sigmas = c.result.at("largest").is_null() ? INFINITY : c.result.at("largest").get<double>();
  ++row->n;
  row->reported += reported(kind, names, cause) ? 1 : 0;
  for (const std::string& name : names) ++row->names[name];
  row->seconds = std::max(row->seconds, c.result.at("seconds").get<double>());
  if (c.result.at("status") != "calibrated") {
    if (row->cause.empty()) row->cause = cause;
    return;
  }
  ++row->calibrated;
  if (sigmas > row->largest.sigmas) row->largest = {sigmas, c.result.at("largest_of")};
  if (sigmas <= wrong_sigmas) return;
  ++row->wrong;
  std::map<std::string, int> once;
  for (const std::string& name : names) once[name] = 1;
  wrong->rows.push_back({kind.name, c.parameters.at("seed"), sigmas, c.result.at("largest_of"),
                         c.result.at("chi2_per_dof"), joined(once, 1)});
}

}  // namespace

Findings faults_gather(const std::vector<CellResult>& cells) {
  std::map<std::string, Json> clean;  // counters, by seed
  for (const CellResult& c : cells)
    if (c.parameters.at("kind") == fault_kinds().front().name)
      clean[c.parameters.at("seed").dump()] = c.result.at("said").at("counters");
  std::map<std::string, KindRow> rows;
  Table wrong{"Called calibrated, and wrong",
              "Beyond five sigma.",
              {{"fault", ""}, {"seed", "-"}, {"largest error", "sigma"}, {"of", ""}, {"chi2/dof", "-"}, {"named", ""}},
              {}};
  for (const CellResult& c : cells)
    add_run(c, clean[c.parameters.at("seed").dump()], &rows[c.parameters.at("kind")], &wrong);
  Table table{"Faults",
              "Named: fault counters above those of the clean recording, suspects of the review, the clock's offset; "
              "in brackets the runs, where "
              "it was not all. Errors are of released entries of calibrated runs, in their sigmas.",
              {{"fault", ""},
               {"what", ""},
               {"runs", "-"},
               {"reported by name", "-"},
               {"calibrated", "-"},
               {"beyond 5 sigma", "-"},
               {"largest error", "sigma"},
               {"of", ""},
               {"named", ""},
               {"cause of a refusal", ""},
               {"longest replay", "s"}},
              {}};
  int all_wrong = 0, all_calibrated = 0, unreported = 0;
  for (const FaultKind& kind : fault_kinds()) {
    if (!rows.count(kind.name)) continue;
    const KindRow& r = rows[kind.name];
    table.rows.push_back({kind.name, kind.what, r.n, r.reported, r.calibrated, r.wrong,
                          r.calibrated ? Json(r.largest.sigmas) : Json(), r.largest.of, joined(r.names, r.n), r.cause,
                          r.seconds});
    all_wrong += r.wrong;
    all_calibrated += r.calibrated;
    unreported += r.n - r.reported;
  }
  Findings out;
  out.tables = {table, wrong};
  out.limits = {{"wrong answers of " + std::to_string(all_calibrated) + " called calibrated",
                 static_cast<double>(all_wrong), 0, "-", false},
                {"runs whose fault was not reported by name", static_cast<double>(unreported), 0, "-", false}};
  return out;
}

}  // namespace host::experiments
