// Faults in the data: is each reported by name, and is what is then called calibrated right? Every recording goes the
// way of `segcal replay`: clocks compared, calibrated, reviewed.
#include <cmath>
#include <ctime>
#include <map>

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
  sim::parse_effect(kind.effect)->on_camera_calibration({end, 0}, out[1].cameras[0]);
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
  for (const Suspect& s : r.health.suspects)
    if (s.certain) suspects.push_back(s.name);
  Json clock;
  if (!r.clocks.empty() && r.clocks.front().differs_from(0)) clock = "time_offset: " + r.clocks.front().words;
  return {{"counters", counters}, {"suspects", suspects}, {"clock", clock}, {"cause", r.cause}};
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

}  // namespace host::experiments
