// What a diagnosis found, put into a simulation.
#include <algorithm>

#include "diagnose/hypotheses.h"
#include "formatted.h"
#include "simulate/effect_names.h"
#include "simulate/effects_variance.h"
#include "twin/make.h"

namespace host::twin {
namespace {

/// Values count from the recording's own stamps. The twin has what is left beyond the stated offset and the stated
/// share of the exposure, and states neither.
double value_of(const DiagnosedEffect& e, std::size_t i, const DiagnoseOptions& options, double later_s) {
  const double value = e.parameters[i].value;
  if (e.name == "time_offset") return value - options.core.calibration.cameras.front().timeshift_cam_imu;
  if (e.name == diagnosis::kExposureOffset) return value - options.stamp_exposure;
  return e.name == diagnosis::kCalibrationShift && i == 0 ? value - later_s : value;
}

/// Of a step: its parameters are "calibration_shift.cam0.r_CI.x" and so on.
std::string block_of(const DiagnosedEffect& e) {
  const std::string& entry = e.parameters.back().name;
  return entry.substr(entry.find('.') + 1, entry.rfind('.') - entry.find('.') - 1);
}

/// "NAME=v1,v2", as `segcal simulate --effect` takes it.
std::string as_option(const DiagnosedEffect& e, const DiagnoseOptions& options, double later_s) {
  std::string text = e.name + "=";
  if (e.name == diagnosis::kCalibrationShift) text += block_of(e) + ",";
  for (std::size_t i = 0; i < e.parameters.size(); ++i) {
    text += formatted(i > 0 ? ",%.6g" : "%.6g", value_of(e, i, options, later_s));
  }
  return text;
}

/// As samples and corners show it, named or not. A walk along tracks only where the diagnosis weighed them by one: what
/// a fit leaves of a step, or of what has no name, walks as well, and the diagnosis tells the two apart by neighbours.
void add_noise(const Diagnosis& found, double stated_px, SimulationOptions* out, Comparison* said) {
  out->tracks.pixel_noise_px = found.tracks.points > 0   ? found.tracks.white_px
                               : found.pixels.factor > 0 ? found.pixels.factor * stated_px
                                                         : stated_px;
  out->tracks.walk_px_per_sqrt_s = found.tracks.points > 0 ? found.tracks.walk_px_per_sqrt_s : 0;
  said->effects.push_back(
      formatted("corners of %.3g px and %.3g px/sqrt(s)", out->tracks.pixel_noise_px, out->tracks.walk_px_per_sqrt_s));
  const auto factor = [](const SensorNoise& n) {
    return n.verdict == SensorNoise::Verdict::cannot_tell || n.factor <= 0 ? 1 : n.factor;
  };
  const std::string text =
      formatted("imu_noise=%.4g,%.4g", factor(found.raw_noise.gyro), factor(found.raw_noise.accel));
  out->effects.push_back(sim::parse_effect(text));
  said->effects.push_back(text);
}

}  // namespace

const ReplayResult& last_fit(const Diagnosis& d) { return d.fit_after.kept.empty() ? d.fit_before : d.fit_after; }

void put_before_step(const Diagnosis& found, Calibration* device) {
  for (const DiagnosedEffect& e : found.effects) {
    if (e.name != diagnosis::kCalibrationShift) continue;
    try {
      const sim::CalibrationShift before(block_of(e), -1e9, found.before_step);
      for (std::size_t i = 0; i < device->cameras.size(); ++i) before.on_camera_calibration({0, i}, device->cameras[i]);
      before.on_imu_calibration(0, device->imu);
    } catch (const InputError&) {
      return;  // a block that the simulator cannot move: with_effects says so
    }
  }
}

SimulationOptions with_effects(SimulationOptions out, const Recording& session, const Diagnosis& found,
                               const DiagnoseOptions& options, Comparison* said) {
  const double later =
      1e-9 * static_cast<double>(out.replica->poses.first_ns - session.cameras.front().frames.front().t_ns);
  for (const DiagnosedEffect& e : found.effects) {
    if (diagnosis::hypothesis(e.name).kind == diagnosis::Kind::noise) continue;
    try {
      if (e.name == diagnosis::kUnlisted) throw InputError("terms without a name have no model");
      const std::string text = as_option(e, options, later);
      out.effects.push_back(sim::parse_effect(text));
      said->effects.push_back(text);
    } catch (const InputError&) {
      said->not_simulated.push_back(e.name == diagnosis::kUnlisted ? e.words : e.name);
    }
  }
  add_noise(found, options.core.pixel_sigma, &out, said);
  return out;
}

}  // namespace host::twin
