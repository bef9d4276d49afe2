// The configuration and the inputs of one profile's C API, from
// the host's. Included once per profile by the sources here.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>

#include "log/config_fields.h"
#include "replay/config_file.h"
#include "replay/core.h"
#include "segcal/segcal.h"

namespace host {
namespace SEGCAL_NS {

inline int metric_code(const std::string& name) {
  if (name == "A") return SEGCAL_METRIC_A;
  if (name == "D") return SEGCAL_METRIC_D;
  if (name == "E") return SEGCAL_METRIC_E;
  if (name == "random") return SEGCAL_METRIC_RANDOM;
  if (name == "set_d") return SEGCAL_METRIC_SET_D;
  throw InputError("--metric: expected A, D, E, set_d or random, found '" + name + "'");
}

inline void put_rotation(const Eigen::Matrix3d& R, double* q_wxyz) {
  const Eigen::Quaterniond q(R);
  q_wxyz[0] = q.w();
  q_wxyz[1] = q.x();
  q_wxyz[2] = q.y();
  q_wxyz[3] = q.z();
}

inline Eigen::Matrix3d rotation(const double* q_wxyz) {
  return Eigen::Quaterniond(q_wxyz[0], q_wxyz[1], q_wxyz[2], q_wxyz[3]).normalized().toRotationMatrix();
}

inline void put_triangle(const Eigen::Matrix3d& T, double* scale, double* misalignment) {
  for (int i = 0; i < 3; ++i) scale[i] = T(i, i);
  misalignment[0] = T(0, 1);
  misalignment[1] = T(0, 2);
  misalignment[2] = T(1, 2);
}

inline Eigen::Matrix3d triangle(const double* scale, const double* misalignment) {
  Eigen::Matrix3d T;
  T << scale[0], misalignment[0], misalignment[1], 0, scale[1], misalignment[2], 0, 0, scale[2];
  return T;
}

inline segcal_camera_t camera_to_c(const CameraCalibration& camera) {
  segcal_camera_t out{};
  out.model = static_cast<int>(camera.model);
  put_rotation(camera.R_CI, out.q_CI);
  for (int i = 0; i < 3; ++i) out.p_CI[i] = camera.p_CI(i);
  for (int i = 0; i < 4; ++i) out.intrinsics[i] = camera.intrinsics(i);
  for (int i = 0; i < 4; ++i) out.distortion[i] = camera.distortion(i);
  out.height = camera.height;
  if (camera.reads_columns)
    out.height = -(camera.width > 0 ? camera.width : std::max(1, static_cast<int>(2 * camera.intrinsics(2))));
  return out;
}

inline segcal_term_t term_to_c(const CoreTerm& t) {
  return {static_cast<std::uint8_t>(t.kind), static_cast<std::uint8_t>(t.a), static_cast<std::uint8_t>(t.b),
          static_cast<std::uint8_t>(t.c)};
}

inline void configure_effects(const CoreOptions& options, segcal_config_t* c) {
  constexpr std::size_t room = SEGCAL_MAX_EFFECT_ESTIMATES;
  if (options.terms.size() > room || options.term_values.size() > room) {
    throw InputError("effects: this profile estimates at most " + std::to_string(room) + " terms, found " +
                     std::to_string(std::max(options.terms.size(), options.term_values.size())));
  }
  c->estimate_effects = options.effects;
  c->n_terms = static_cast<int>(options.terms.size());
  for (std::size_t i = 0; i < options.terms.size(); ++i) c->term[i] = term_to_c(options.terms[i]);
  for (std::size_t i = 0; i < options.term_values.size(); ++i) c->term_value[i] = options.term_values[i];
  c->has_temperature = options.has_temperature ? 1 : 0;
  c->watch_effects = options.watched_effects;
}

/// What the sensors are: calibration, priors, noise.
inline void configure_sensors(const CoreOptions& options, segcal_config_t* c) {
  c->n_cameras = static_cast<int>(options.calibration.cameras.size());
  if (c->n_cameras > SEGCAL_MAX_CAMERAS) {
    throw InputError("--cameras: this profile holds " + std::to_string(SEGCAL_MAX_CAMERAS) + ", found " +
                     std::to_string(c->n_cameras));
  }
  for (int i = 0; i < c->n_cameras; ++i) c->camera[i] = camera_to_c(options.calibration.cameras[i]);
  put_triangle(options.calibration.imu.T_g, c->imu.gyro_scale, c->imu.gyro_misalignment);
  put_triangle(options.calibration.imu.T_a, c->imu.accel_scale, c->imu.accel_misalignment);
  put_rotation(options.calibration.imu.R_AI, c->imu.q_AI);
  const std::vector<double> sigmas = prior_sigmas(options.prior_sigma, options.calibration);
  std::copy_n(sigmas.begin(), std::min<std::size_t>(sigmas.size(), SEGCAL_MAX_PARAMETERS), c->prior_sigma);
  c->gravity = options.gravity;
  c->imu_rate_hz = options.noise.rate_hz;
  c->gyro_noise_density = options.noise.gyro_noise_density;
  c->gyro_random_walk = options.noise.gyro_random_walk;
  c->accel_noise_density = options.noise.accel_noise_density;
  c->accel_random_walk = options.noise.accel_random_walk;
  c->pixel_sigma = options.pixel_sigma;
  if (options.track_walk > 0 && SEGCAL_TRACK_WALK == 0) {
    throw InputError("--track-walk: this profile is built without (SEGCAL_TRACK_WALK)");
  }
  c->track_walk = options.track_walk;
}

/// How segments are cut, kept and used.
inline void configure_database(const CoreOptions& options, segcal_config_t* c) {
  c->segment_s = options.segment_s;
  if (options.adaptive_segments) {
    c->least_segment_s = 0.5 * options.segment_s;
    c->most_segment_s = 2 * options.segment_s;
  }
  if (options.segments > SEGCAL_MAX_SEGMENTS) {
    throw InputError("--segments: this profile keeps at most " + std::to_string(SEGCAL_MAX_SEGMENTS) + ", found " +
                     std::to_string(options.segments));
  }
  c->keep_segments = options.segments;
  c->metric = metric_code(options.metric);
  c->strategy = options.multi_session ? SEGCAL_MULTI_SESSION : SEGCAL_SINGLE_SESSION;
  c->seed = options.seed;
  c->outdated_level = options.outdated_level;
  c->trigger_fraction = options.trigger_fraction > 0 ? options.trigger_fraction : options.condense ? 0 : -1;
  c->filter_share = options.hold_calibration ? 1e-3 : 1;
  for (std::size_t i = 0; i < options.sigma_ref.size() && i < SEGCAL_MAX_PARAMETERS; ++i)
    c->sigma_ref[i] = options.sigma_ref[i];
  c->condense = options.condense ? 1 : 0;
  if (options.condense) c->calibration_window = 1;  // a host is done at once: no segment is missed meanwhile but one
  c->joint_filter = options.joint_ekf ? 1 : 0;
}

inline segcal_config_t config_of(const CoreOptions& options) {
  segcal_config_t c{};
  if (!options.device_config.empty()) {
    if (::SEGCAL_NS::read_config(options.device_config.data(), options.device_config.size(), &c)) return c;
    throw InputError("--profile: expected one with the device's number of cameras (" +
                     std::to_string(options.calibration.cameras.size()) + "), found " +
                     std::to_string(SEGCAL_MAX_CAMERAS));
  }
  configure_sensors(options, &c);
  configure_database(options, &c);
  configure_effects(options, &c);
  if (options.joint_ekf && (options.effects & SEGCAL_EFFECT_CAMERA_TEMPERATURE) != 0)
    throw InputError("--joint-ekf: expected effects without camera_temperature, of which the filter has no model");
  return c;
}

inline segcal_imu_t sample_to_c(const ImuSample& sample) {
  segcal_imu_t s{};
  s.t_ns = sample.t_ns;
  for (int i = 0; i < 3; ++i) {
    s.gyro[i] = static_cast<float>(sample.gyro[i]);
    s.accel[i] = static_cast<float>(sample.accel[i]);
  }
  s.temperature = static_cast<float>(sample.temperature_degC);
  return s;
}

/// As many points of each camera as the profile takes.
inline void points_to_c(const std::vector<const Frame*>& per_camera, std::vector<segcal_point_t>* out) {
  out->clear();
  for (std::size_t c = 0; c < per_camera.size(); ++c) {
    if (!per_camera[c]) continue;
    const std::size_t fits = std::min<std::size_t>(per_camera[c]->points.size(), SEGCAL_MAX_TRACKS);
    for (std::size_t i = 0; i < fits; ++i) {
      const TrackPoint& p = per_camera[c]->points[i];
      out->push_back({p.track_id, static_cast<int>(c), static_cast<float>(p.u), static_cast<float>(p.v)});
    }
  }
}

}  // namespace SEGCAL_NS
}  // namespace host
