#include "experiments/datasets.h"

#include <algorithm>
#include <map>

#include "angles.h"
#include "compare/trajectory_error.h"
#include "replay/replay.h"
#include "simulate/device.h"

namespace host::experiments {
namespace {

// Seeds of sessions must not meet: datasets are 1000 apart, evaluation sessions begin far above.
constexpr std::int64_t settle_ns = 15000000000;  // the filter's start, which is not what calibrations are compared by
constexpr std::uint64_t seeds_per_study = 100000, seeds_per_dataset = 1000, evaluation_seed = 50000;

}  // namespace

const std::vector<Dataset>& datasets() {
  static const std::vector<Dataset> all = {
      {"arvr_office_room", "arvr", true, 5, 120, 60, 0.7, 5},
      {"arvr_class_room", "arvr", true, 5, 120, 60, 0.7, 8},
      {"nav_parking_garage", "nav", false, 3, 300, 35, 0.7, 8},
      {"nav_office_building", "nav", false, 3, 300, 60, 0.7, 6},
  };
  return all;
}

const Dataset& dataset_named(const std::string& name) {
  for (const Dataset& d : datasets()) {
    if (name == d.name) return d;
  }
  throw InputError("unknown dataset '" + name + "'");
}

SimulationResult simulate_session(const Dataset& dataset, std::uint64_t seed, int index, double session_s) {
  const auto place = static_cast<std::uint64_t>(&dataset - datasets().data());
  SimulationOptions options;
  options.scenario = dataset.scenario;
  options.seconds = session_s;
  options.seed = seed * seeds_per_study + place * seeds_per_dataset + static_cast<std::uint64_t>(index);
  options.device_seed = seed;
  options.tracks.count = dataset.tracks;
  options.tracks.depth = {dataset.near_m, dataset.far_m};
  return simulate(options);
}

SimulationResult simulate_cell(const Json& parameters) {
  SimulationOptions options;
  options.scenario = parameters.at("scenario");
  options.seconds = parameters.at("seconds");
  options.seed = parameters.at("seed");
  return simulate(options);
}

SimulationResult simulate_evaluation(std::uint64_t seed, int index, double session_s) {
  static const char* const scenario[] = {"nav", "arvr", "rich"};
  SimulationOptions options;
  options.scenario = scenario[index % 3];
  options.seconds = session_s;
  options.seed = seed * seeds_per_study + evaluation_seed + static_cast<std::uint64_t>(index);
  options.device_seed = seed;
  return simulate(options);
}

OdometryError odometry_error(const SimulationResult& session, const Calibration& calibration, Odometry odometry) {
  ReplayOptions options;
  options.core.calibration = calibration;
  options.core.noise = session.recording.imu.noise;
  options.calibrate = false;
  options.core.hold_calibration = odometry == Odometry::held;
  const ReplayResult replayed = replay({session.recording}, options);
  Poses poses = poses_of(replayed.trajectory);
  const std::int64_t from = session.recording.cameras[0].frames.front().t_ns + settle_ns;
  poses.erase(poses.begin(),
              std::find_if(poses.begin(), poses.end(), [from](const Pose& p) { return p.t_ns >= from; }));
  const auto e = trajectory_error(poses, poses_of(session.recording.truth), {});
  if (!e) throw InputError("the odometry gave no trajectory");
  return {e->position_m.rmse, e->attitude_rad.rmse};
}

Evaluation::Evaluation(std::uint64_t seed, int count, double session_s) {
  for (int i = 0; i < count; ++i) sessions_.push_back(simulate_evaluation(seed, i, session_s));
}

Json Evaluation::operator()(const Calibration& calibration, Odometry odometry) const {
  Json position = Json::array(), attitude = Json::array();
  for (const SimulationResult& session : sessions_) {
    const OdometryError e = odometry_error(session, calibration, odometry);
    position.push_back(100 * e.position_m);
    attitude.push_back(e.attitude_rad / rad_per_deg);
  }
  return {{"position_cm", position}, {"attitude_deg", attitude}};
}

Json parameters_json(const CoreResult& result, const Calibration& truth) {
  std::map<std::string, double> true_value;
  for (const sim::NamedParameter& p : sim::named_parameters(truth, true)) true_value[p.name] = p.value;
  Json out = Json::array();
  for (const CoreParameter& p : result.parameters) {
    out.push_back({{"name", p.name},
                   {"unit", p.unit},
                   {"value", p.value},
                   {"sigma", p.sigma},
                   {"prior_sigma", p.prior_sigma},
                   {"initial", p.initial},
                   {"truth", true_value.at(p.name)},
                   {"verdict", p.verdict}});
  }
  return out;
}

}  // namespace host::experiments
