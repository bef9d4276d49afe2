// Checks of a configuration that comes through the C API, and the device's options from it.
#include "api/camera_from_c.h"
#include "api/convert.h"

namespace SEGCAL_NS {
namespace {

// Ranges of what the C API takes; segcal.h states them.
constexpr double kMostMisalignment = 10;

bool imu_from_c(const segcal_imu_calibration_t& in, ImuCalibration<Real>* out) {
  const auto scale = [](const double* s, Vec3<Real>* v) {
    for (int i = 0; i < 3; ++i) {
      if (!accept_or_default(s[i], 1, 0.5001, 1.9999, &(*v)(i))) return false;
    }
    return true;
  };
  return scale(in.gyro_scale, &out->gyro_scale) && scale(in.accel_scale, &out->accel_scale) &&
         accept_vector<3>(in.gyro_misalignment, -kMostMisalignment, kMostMisalignment, &out->gyro_misalignment) &&
         accept_vector<3>(in.accel_misalignment, -kMostMisalignment, kMostMisalignment, &out->accel_misalignment) &&
         accept_rotation(in.q_AI, &out->R_AI);
}

/// As many samples become one as memory asks for: the history must
/// hold a start of kStartSeconds, a segment all of its samples.
std::int32_t group_for(double rate_hz, double segment_s) {
  const double history = SEGCAL_IMU_HISTORY / kStartSeconds;
  const double segment = SEGCAL_MAX_IMU_SAMPLES / (segment_s + 0.1);   // from the keyframe before it to its last one
  const double most = 1.02 * (history < segment ? history : segment);  // 2 %: what oscillators are off by
  std::int32_t group = 1;
  while (rate_hz > most * group) ++group;
  return group;
}

bool noise_from_config(const segcal_config_t& c, DeviceOptions<Real>* out) {
  Real gravity;
  if (!accept_or_default(c.gravity, 9.80665, 1e-3, 100, &gravity)) return false;
  out->model.g = Vec3<Real>(Real(0), Real(0), -gravity);
  if (!is_finite(c.track_walk) || c.track_walk < 0 || c.track_walk > (kTrackWalk ? 100 : 0)) return false;
  out->model.track_walk = static_cast<Real>(c.track_walk);
  const auto density = [](double value, double fallback, double most, Real* to) {
    return accept_or_default(value, fallback, kLeastSigma, most, to);
  };
  Real rate;
  if (!accept_or_default(c.imu_rate_hz, 200, 20, 20000, &rate) ||
      !accept_or_default(c.segment_s, 4, 0.1, 60, &out->segment_s))
    return false;
  out->imu_group = group_for(c.imu_rate_hz == 0 ? 200 : c.imu_rate_hz, static_cast<double>(out->segment_s));
  out->imu_rate_hz = rate;
  return density(c.gyro_noise_density, 1.7e-4, 1, &out->model.imu.gyro) &&
         density(c.gyro_random_walk, 2e-5, 1, &out->model.imu.gyro_walk) &&
         density(c.accel_noise_density, 2e-3, 10, &out->model.imu.accel) &&
         density(c.accel_random_walk, 3e-4, 10, &out->model.imu.accel_walk) &&
         accept_or_default(c.gyro_range, 35, 0.01, 1e4, &out->gyro_range) &&
         accept_or_default(c.accel_range, 157, 0.1, 1e5, &out->accel_range) &&
         accept_or_default(c.pixel_sigma, 0.5, 1e-3, 100, &out->model.pixel_sigma) &&
         accept_or_default(c.frame_interval_s, 0.1, 1e-3, 2, &out->frame_interval_s);
}

/// Theta's terms: effects by bit, then the further ones.
bool effects_from_config(const segcal_config_t& c, DeviceOptions<Real>* out) {
  if (c.estimate_effects >> kEffects || c.watch_effects >> kEffects) return false;
  if (c.n_terms < 0 || c.n_terms > SEGCAL_MAX_EFFECT_ESTIMATES) return false;
  EffectTerms<Real>& effects = out->prior.mean.effects;
  CandidateTerms wanted;
  for (int e = 0; e < kEffects; ++e) {
    if (!(c.estimate_effects >> e & 1)) continue;
    if (wanted.n + effect_entry(e).n > SEGCAL_MAX_EFFECT_ESTIMATES) return false;
    for (int i = 0; i < effect_entry(e).n; ++i) wanted.term[wanted.n++] = effect_term(e, i);
  }
  for (int i = 0; i < c.n_terms; ++i) {
    if (wanted.n == SEGCAL_MAX_EFFECT_ESTIMATES || !term_from_c(c.term[i], &wanted.term[wanted.n])) return false;
    for (int k = 0; k < wanted.n; ++k) {
      if (wanted.term[k] == wanted.term[wanted.n]) return false;
    }
    ++wanted.n;
  }
  int columns = wanted.n;
  for (int e = 0; e < kEffects; ++e)
    columns += (c.watch_effects & ~c.estimate_effects) >> e & 1 ? effect_entry(e).n : 0;
  if (columns > SEGCAL_MAX_EFFECT_COLUMNS) return false;
  out->watch_effects = c.watch_effects;
  for (int i = 0; i < wanted.n; ++i) {
    Real value;
    if (!accept(c.term_value[i], -kMostSigma, kMostSigma, &value)) return false;
    effects.add(wanted.term[i], value);
  }
  return true;
}

bool sigmas_from_config(const segcal_config_t& c, DeviceOptions<Real>* out) {
  default_prior_sigmas(out->prior.mean, out->prior.sigma);
  out->calibrates_itself = c.trigger_fraction != -1;
  if (out->calibrates_itself && !(c.trigger_fraction >= 0 && c.trigger_fraction < 1)) return false;
  for (int i = 0; i < out->prior.mean.columns(); ++i) {
    const auto sigma = [](double value, Real fallback, Real* to) {
      return accept_or_default(value, static_cast<double>(fallback), kLeastSigma, kMostSigma, to);
    };
    if (!sigma(c.prior_sigma[i], out->prior.sigma[i], &out->prior.sigma[i])) return false;
    if (!sigma(c.sigma_ref[i], out->prior.sigma[i], &out->sigma_ref[i])) return false;
    const double relative =
        (out->calibrates_itself ? c.trigger_fraction : 0) * static_cast<double>(out->prior.sigma[i]);
    if (!accept_or_default(c.trigger_sigma[i], relative, 0, kMostSigma, &out->target_sigma[i])) return false;
  }
  return true;
}

}  // namespace

bool options_from_config(const segcal_config_t& c, DeviceOptions<Real>* out) {
  if (c.n_cameras < 0 || c.n_cameras > SEGCAL_MAX_CAMERAS) return false;
  if (c.keep_segments < 0 || c.keep_segments > SEGCAL_MAX_SEGMENTS) return false;
  if (c.metric < SEGCAL_METRIC_A || c.metric > SEGCAL_METRIC_SET_D) return false;
  if (c.strategy != SEGCAL_SINGLE_SESSION && c.strategy != SEGCAL_MULTI_SESSION) return false;
  out->prior.mean = Calibration<Real>();
  out->prior.mean.n_cameras = c.n_cameras == 0 ? 1 : c.n_cameras;
  for (int i = 0; i < out->prior.mean.n_cameras; ++i) {
    if (!camera_from_c(c.camera[i], &out->prior.mean.camera[i])) return false;
  }
  if (!imu_from_c(c.imu, &out->prior.mean.imu) || !noise_from_config(c, out) || !effects_from_config(c, out))
    return false;
  out->has_temperature = c.has_temperature != 0;
  out->keep_segments = c.keep_segments > 0 ? c.keep_segments : (SEGCAL_MAX_SEGMENTS < 8 ? SEGCAL_MAX_SEGMENTS : 8);
  out->metric = static_cast<Metric>(c.metric);
  out->strategy = static_cast<Strategy>(c.strategy);
  out->seed = c.seed;
  out->joint_filter = c.joint_filter != 0;
  if (out->joint_filter && has_warm_camera(out->prior.mean)) return false;
  if (c.calibration_window < 0 || c.calibration_window > 1000) return false;
  out->calibration_window = c.calibration_window == 0 ? 4 : c.calibration_window;
  if (c.condense < 0 || c.condense > (kEpochs > 0 ? 1 : 0)) return false;
  out->condense = c.condense == 1;
  if (!(c.least_segment_s >= 0 && c.least_segment_s <= double(out->segment_s))) return false;
  if (c.most_segment_s != 0 && !(c.most_segment_s >= double(out->segment_s) && c.most_segment_s <= 60)) return false;
  out->most_segment_s =
      Real(c.most_segment_s == 0 && c.least_segment_s > 0 ? double(out->segment_s) : c.most_segment_s);
  out->least_segment_s = c.least_segment_s == 0 ? out->segment_s : Real(c.least_segment_s);
  if (c.outdated_level == -1) {
    out->outdated_level = Real(0);
  } else if (!accept_or_default(c.outdated_level, 1e-3, 1e-9, 0.1, &out->outdated_level)) {
    return false;
  }
  // Half a nat per parameter: what stands still, or is only shaken by motors, stays well below.
  return accept_or_default(c.filter_share, 1, 1e-6, 1, &out->filter_share) &&
         accept_or_default(c.least_gain_nats, 0.5 * out->prior.mean.columns(), 1e-9, 1e6, &out->least_gain) &&
         sigmas_from_config(c, out);
}

}  // namespace SEGCAL_NS
