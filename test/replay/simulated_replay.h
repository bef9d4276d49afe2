// A simulated session and its replay, both in memory, and how far the result is from the truth.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>

#include "replay/replay.h"
#include "simulate/device.h"
#include "simulate/simulate.h"

namespace test {

inline host::SimulationResult simulated(const std::string& scenario, double seconds, std::uint64_t seed) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = seconds;
  options.seed = seed;
  return host::simulate(options);
}

/// With a second camera beside the first. `matches`: corners that both see have one track id.
inline host::SimulationResult simulated_pair(const std::string& scenario, double seconds, std::uint64_t seed,
                                             bool matches) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = seconds;
  options.seed = seed;
  options.cameras = 2;
  options.stereo_matches = matches;
  return host::simulate(options);
}

/// As `segcal replay` does it, from the device's data sheet.
inline host::ReplayResult replayed(const host::SimulationResult& session, const std::string& profile = "mobile",
                                   int segments = 0) {
  host::ReplayOptions options;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  options.core.segments = segments;
  options.profile = profile;
  return host::replay({session.recording}, options);
}

/// (value - truth) / sigma by name. Rotations: components of the rotation vector, as values and sigmas are.
inline std::map<std::string, double> normalised_errors(const host::SimulationResult& session,
                                                       const host::CoreResult& result) {
  std::map<std::string, double> truth, out;
  for (const auto& p : host::sim::named_parameters(session.truth, true)) truth[p.name] = p.value;
  for (const host::CoreParameter& p : result.parameters) out[p.name] = (p.value - truth.at(p.name)) / p.sigma;
  return out;
}

inline std::map<std::string, double> sigmas(const host::CoreResult& result) {
  std::map<std::string, double> out;
  for (const host::CoreParameter& p : result.parameters) out[p.name] = p.sigma;
  return out;
}

/// cam0.r_CI.x -> cam0.r_CI; cam0.fx -> cam0.f; gyro.sx -> gyro.s: parameters of one kind.
inline std::string kind_of(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  if (dot != name.find('.')) return name.substr(0, dot);
  return name.substr(0, dot + 2);
}

/// The loosest sigma of each kind.
inline std::map<std::string, double> largest_by_kind(const std::map<std::string, double>& by_name) {
  std::map<std::string, double> out;
  for (const auto& [name, value] : by_name) out[kind_of(name)] = std::max(out[kind_of(name)], value);
  return out;
}

inline bool long_run() {
  const char* const set = std::getenv("SEGCAL_LONG");
  return set && *set;
}

}  // namespace test
