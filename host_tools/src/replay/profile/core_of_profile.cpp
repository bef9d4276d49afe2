// The C API of one profile behind host::Core. Compiled once per profile; all names that depend on capacities are in
// that profile's own namespace.
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "replay/core.h"
#include "segcal/segcal.h"

#define SEGCAL_FACTORY_2(profile) make_core_##profile
#define SEGCAL_FACTORY_1(profile) SEGCAL_FACTORY_2(profile)
#define SEGCAL_FACTORY SEGCAL_FACTORY_1(SEGCAL_NS)

namespace host {
namespace SEGCAL_NS {

int metric_code(const std::string& name) {
  if (name == "A") return SEGCAL_METRIC_A;
  if (name == "D") return SEGCAL_METRIC_D;
  if (name == "E") return SEGCAL_METRIC_E;
  if (name == "random") return SEGCAL_METRIC_RANDOM;
  if (name == "set_d") return SEGCAL_METRIC_SET_D;
  throw InputError("--metric: expected A, D, E, set_d or random, found '" + name + "'");
}

void put_rotation(const Eigen::Matrix3d& R, double* q_wxyz) {
  const Eigen::Quaterniond q(R);
  q_wxyz[0] = q.w();
  q_wxyz[1] = q.x();
  q_wxyz[2] = q.y();
  q_wxyz[3] = q.z();
}

Eigen::Matrix3d rotation(const double* q_wxyz) {
  return Eigen::Quaterniond(q_wxyz[0], q_wxyz[1], q_wxyz[2], q_wxyz[3]).normalized().toRotationMatrix();
}

void put_triangle(const Eigen::Matrix3d& T, double* scale, double* misalignment) {
  for (int i = 0; i < 3; ++i) scale[i] = T(i, i);
  misalignment[0] = T(0, 1);
  misalignment[1] = T(0, 2);
  misalignment[2] = T(1, 2);
}

Eigen::Matrix3d triangle(const double* scale, const double* misalignment) {
  Eigen::Matrix3d T;
  T << scale[0], misalignment[0], misalignment[1], 0, scale[1], misalignment[2], 0, 0, scale[2];
  return T;
}

segcal_camera_t camera_to_c(const CameraCalibration& camera) {
  segcal_camera_t out{};
  out.model = static_cast<int>(camera.model);
  put_rotation(camera.R_CI, out.q_CI);
  for (int i = 0; i < 3; ++i) out.p_CI[i] = camera.p_CI(i);
  for (int i = 0; i < 4; ++i) out.intrinsics[i] = camera.intrinsics(i);
  for (int i = 0; i < 4; ++i) out.distortion[i] = camera.distortion(i);
  out.height = camera.height;
  return out;
}

segcal_term_t term_to_c(const CoreTerm& t) {
  return {static_cast<std::uint8_t>(t.kind), static_cast<std::uint8_t>(t.a), static_cast<std::uint8_t>(t.b), static_cast<std::uint8_t>(t.c)};
}

void configure_effects(const CoreOptions& options, segcal_config_t* c) {
  constexpr std::size_t room = SEGCAL_MAX_EFFECT_ESTIMATES;
  if (options.terms.size() > room || options.term_values.size() > room) {
    throw InputError("effects: this profile estimates at most " + std::to_string(room) + " terms, found " +
                     std::to_string(std::max(options.terms.size(), options.term_values.size())));
  }
  c->estimate_effects = options.effects;
  c->watch_effects = options.watched_effects;
  c->n_terms = static_cast<int>(options.terms.size());
  for (std::size_t i = 0; i < options.terms.size(); ++i) c->term[i] = term_to_c(options.terms[i]);
  for (std::size_t i = 0; i < options.term_values.size(); ++i) c->term_value[i] = options.term_values[i];
  c->has_temperature = options.has_temperature ? 1 : 0;
}

segcal_config_t config_of(const CoreOptions& options) {
  segcal_config_t c{};
  c.n_cameras = static_cast<int>(options.calibration.cameras.size());
  if (c.n_cameras > SEGCAL_MAX_CAMERAS) {
    throw InputError("--cameras: this profile holds " + std::to_string(SEGCAL_MAX_CAMERAS) + ", found " +
                     std::to_string(c.n_cameras));
  }
  for (int i = 0; i < c.n_cameras; ++i) c.camera[i] = camera_to_c(options.calibration.cameras[i]);
  put_triangle(options.calibration.imu.T_g, c.imu.gyro_scale, c.imu.gyro_misalignment);
  put_triangle(options.calibration.imu.T_a, c.imu.accel_scale, c.imu.accel_misalignment);
  put_rotation(options.calibration.imu.R_AI, c.imu.q_AI);
  c.imu_rate_hz = options.noise.rate_hz;
  c.gyro_noise_density = options.noise.gyro_noise_density;
  c.gyro_random_walk = options.noise.gyro_random_walk;
  c.accel_noise_density = options.noise.accel_noise_density;
  c.accel_random_walk = options.noise.accel_random_walk;
  c.pixel_sigma = options.pixel_sigma;
  c.segment_s = options.segment_s;
  if (options.adaptive_segments) {
    c.least_segment_s = 0.5 * options.segment_s;
    c.most_segment_s = 2 * options.segment_s;
  }
  if (options.segments > SEGCAL_MAX_SEGMENTS) {
    throw InputError("--segments: this profile keeps at most " + std::to_string(SEGCAL_MAX_SEGMENTS) + ", found " +
                     std::to_string(options.segments));
  }
  c.keep_segments = options.segments;
  c.metric = metric_code(options.metric);
  c.strategy = options.multi_session ? SEGCAL_MULTI_SESSION : SEGCAL_SINGLE_SESSION;
  c.seed = options.seed;
  c.outdated_level = options.outdated_level;
  c.trigger_fraction = options.trigger_fraction;
  c.filter_share = options.hold_calibration ? 1e-3 : 1;
  for (std::size_t i = 0; i < options.sigma_ref.size() && i < SEGCAL_MAX_PARAMETERS; ++i) c.sigma_ref[i] = options.sigma_ref[i];
  c.joint_filter = options.joint_ekf ? 1 : 0;
  configure_effects(options, &c);
  return c;
}

CoreState state_of(const segcal_state_t& s) {
  CoreState out;
  out.t_ns = s.t_ns;
  for (int i = 0; i < 4; ++i) out.q_GI_wxyz(i) = s.q_GI[i];
  for (int i = 0; i < 3; ++i) {
    out.p_GI(i) = s.p_GI[i];
    out.v_GI(i) = s.v_GI[i];
    out.b_a(i) = s.b_a[i];
    out.b_g(i) = s.b_g[i];
  }
  return out;
}

CoreSegment segment_of(const segcal_segment_t& s) {
  CoreSegment out;
  out.start_ns = s.start_ns;
  out.end_ns = s.end_ns;
  out.session = s.session;
  out.serial = s.serial;
  out.keyframes = s.keyframes;
  out.landmarks = s.landmarks;
  out.points = s.points;
  out.rank = s.rank;
  out.A = s.A;
  out.D = s.D;
  out.E = s.E;
  out.gain_nats = s.gain_nats;
  out.kept = s.kept != 0;
  return out;
}

class ProfileCore final : public Core {
 public:
  explicit ProfileCore(const CoreOptions& options) : options_(options) {
    const segcal_config_t config = config_of(options);
    const std::size_t bytes = (segcal_storage_bytes() + SEGCAL_STORAGE_ALIGNMENT - 1) / SEGCAL_STORAGE_ALIGNMENT *
                              SEGCAL_STORAGE_ALIGNMENT;
    storage_.reset(std::aligned_alloc(SEGCAL_STORAGE_ALIGNMENT, bytes));
    const int error = segcal_create(&device_, &config, storage_.get(), bytes);
    if (error != SEGCAL_OK) {
      throw InputError("the core refuses this configuration (error " + std::to_string(error) +
                       "): check focal length, distortion and noise values of the calibration");
    }
  }

  void push_imu(const ImuSample& sample) override {
    segcal_imu_t s{};
    s.t_ns = sample.t_ns;
    for (int i = 0; i < 3; ++i) {
      s.gyro[i] = static_cast<float>(sample.gyro[i]);
      s.accel[i] = static_cast<float>(sample.accel[i]);
    }
    s.temperature = static_cast<float>(sample.temperature_degC);
    last_outcome_ = outcome(segcal_push_imu(device_, &s));
  }

  FrameOutcome push_frame(std::int64_t t_ns, const std::vector<const Frame*>& per_camera) override {
    points_.clear();
    for (std::size_t c = 0; c < per_camera.size(); ++c) {
      if (!per_camera[c]) continue;
      const std::size_t fits = std::min<std::size_t>(per_camera[c]->points.size(), SEGCAL_MAX_TRACKS);
      for (std::size_t i = 0; i < fits; ++i) {
        const TrackPoint& p = per_camera[c]->points[i];
        points_.push_back({p.track_id, static_cast<int>(c), static_cast<float>(p.u), static_cast<float>(p.v)});
      }
    }
    return outcome(segcal_push_tracks(device_, t_ns, points_.data(), static_cast<int>(points_.size())));
  }

  bool state(CoreState* out) const override {
    segcal_state_t s;
    if (segcal_get_state(device_, &s) != SEGCAL_OK) return false;
    *out = state_of(s);
    return true;
  }

  bool background() override {
    const bool due = segcal_background(device_, 0) > 0;
    segcal_background(device_, 1);
    return due;
  }
  void flush() override { segcal_flush(device_); }
  void new_session() override { segcal_new_session(device_); }
  bool calibrate() override { return segcal_calibrate(device_) >= 0; }

  bool has_result() const override {
    segcal_result_t r;
    return segcal_get_result(device_, &r) == SEGCAL_OK;
  }

  CoreResult result() const override {
    segcal_result_t r;
    CoreResult out;
    if (segcal_get_result(device_, &r) != SEGCAL_OK) return out;
    static const char* const kStatus[] = {"insufficient", "calibrated", "failed"};
    static const char* const kVerdict[] = {"fixed", "weak", "observed"};
    out.status = kStatus[r.status];
    for (int i = 0; i < r.n_parameters; ++i) {
      const segcal_parameter_t& p = r.parameter[i];
      out.parameters.push_back({p.name, p.unit, kVerdict[p.verdict], p.value, p.initial, p.sigma, p.prior_sigma});
    }
    for (int i = 0; i < r.n_directions; ++i) {
      segcal_direction_t d;
      if (segcal_get_direction(device_, i, &d) == SEGCAL_OK) out.unobservable.push_back(direction(d, r.n_parameters));
    }
    out.iterations = r.iterations;
    out.segments = r.segments;
    out.partitions = r.partitions;
    out.image_points = r.image_points;
    out.converged = r.converged != 0;
    out.chi2 = r.chi2;
    out.dof = r.dof;
    out.noise_scale = r.noise_scale;
    out.reprojection_rms_px = r.reprojection_rms_px;
    out.reprojection_median_px = r.reprojection_median_px;
    return out;
  }

  Calibration calibration() const override {
    Calibration out = options_.calibration;
    for (std::size_t i = 0; i < out.cameras.size(); ++i) {
      segcal_camera_t c;
      segcal_get_camera(device_, static_cast<int>(i), &c);
      out.cameras[i].R_CI = rotation(c.q_CI);
      out.cameras[i].p_CI = Eigen::Vector3d(c.p_CI[0], c.p_CI[1], c.p_CI[2]);
      for (int k = 0; k < 4; ++k) out.cameras[i].intrinsics(k) = c.intrinsics[k];
      for (int k = 0; k < 4; ++k) out.cameras[i].distortion(k) = c.distortion[k];
    }
    segcal_imu_calibration_t imu;
    segcal_get_imu_calibration(device_, &imu);
    out.imu.T_g = triangle(imu.gyro_scale, imu.gyro_misalignment);
    out.imu.T_a = triangle(imu.accel_scale, imu.accel_misalignment);
    out.imu.R_AI = rotation(imu.q_AI);
    return out;
  }

  bool last_segment(CoreSegment* out) override {
    segcal_segment_t s;
    if (segcal_get_segment(device_, -1, &s) != SEGCAL_OK || (seen_ && s.serial == last_serial_)) return false;
    seen_ = true;
    last_serial_ = s.serial;
    *out = segment_of(s);
    std::vector<segcal_direction_t> directions(SEGCAL_MAX_DIRECTIONS);
    const int n = segcal_get_segment_directions(device_, directions.data(), SEGCAL_MAX_DIRECTIONS);
    for (int i = 0; i < n; ++i) out->not_excited.push_back(direction(directions[i], parameters()));
    out->sigma.resize(SEGCAL_MAX_PARAMETERS);
    out->sigma.resize(std::max(0, segcal_get_segment_sigmas(device_, out->sigma.data(), SEGCAL_MAX_PARAMETERS)));
    return true;
  }

  std::vector<CoreKept> kept() const override {
    std::vector<CoreKept> out;
    for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
      segcal_segment_t s;
      if (segcal_get_segment(device_, slot, &s) != SEGCAL_OK || !s.kept) continue;
      out.push_back(kept_slot(slot, s));
    }
    return out;
  }

  CoreModel model() const override {
    segcal_model_t m{};
    segcal_get_model(device_, &m);
    return {m.gyro_noise_density, m.gyro_random_walk, m.accel_noise_density, m.accel_random_walk, m.gravity, m.pixel_sigma,
            m.huber, m.bias_a_sigma, m.bias_g_sigma, m.velocity_sigma, m.inverse_depth_sigma, m.turned_inverse_depth_sigma};
  }

  CoreRows linearise(const std::vector<std::uint32_t>& serials, const std::vector<CoreTerm>& candidates) override {
    std::uint8_t use[SEGCAL_MAX_SEGMENTS + 1] = {};
    for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
      segcal_segment_t s;
      if (segcal_get_segment(device_, slot, &s) != SEGCAL_OK || !s.kept) continue;
      use[slot] = std::find(serials.begin(), serials.end(), s.serial) != serials.end() ? 1 : 0;
    }
    std::vector<segcal_term_t> terms;
    for (const CoreTerm& t : candidates) terms.push_back(term_to_c(t));
    constexpr std::size_t columns = SEGCAL_MAX_CAMERAS * 14 + 15 + SEGCAL_MAX_EFFECT_COLUMNS + 1;
    CoreRows out;
    out.triangle.resize(columns * (columns + 1) / 2);
    std::int32_t n_theta = 0, n_terms = 0, dof = 0;
    const int error = segcal_linearise(device_, use, terms.data(), static_cast<int>(terms.size()), out.triangle.data(),
                                       static_cast<int>(out.triangle.size()), &n_theta, &n_terms, &dof);
    if (error != SEGCAL_OK) throw InputError("the core does not linearise these segments and effects (error " + std::to_string(error) + ")");
    out.n_theta = n_theta;
    out.n_candidates = n_terms;
    out.dof = dof;
    return out;
  }

  std::vector<std::uint32_t> outdated() const override {
    std::vector<std::uint32_t> out;
    for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
      segcal_segment_t s;
      if (segcal_get_segment(device_, slot, &s) == SEGCAL_OK && s.outdated) out.push_back(s.serial);
    }
    return out;
  }

  std::vector<std::pair<std::string, std::uint32_t>> counters() const override {
    segcal_counters_t c;
    segcal_get_counters(device_, &c);
    return {{"imu_samples", c.imu_samples}, {"imu_stamps_back", c.imu_stamps_back}, {"imu_gaps", c.imu_gaps},
            {"imu_not_finite", c.imu_not_finite}, {"imu_saturated", c.imu_saturated}, {"frames", c.frames},
            {"frames_used", c.frames_used}, {"frame_stamps_back", c.frame_stamps_back},
            {"frames_dropped", c.frames_dropped}, {"frames_few_tracks", c.frames_few_tracks},
            {"points_not_finite", c.points_not_finite}, {"filter_restarts", c.filter_restarts},
            {"standstill_frames", c.standstill_frames}, {"features_used", c.features_used},
            {"features_gated", c.features_gated}, {"segments_closed", c.segments_closed},
            {"segments_discarded", c.segments_discarded}, {"segments_unsettled", c.segments_unsettled},
            {"segments_ended_early", c.segments_ended_early},
            {"landmarks_left_out", c.landmarks_left_out}, {"points_left_out", c.points_left_out},
            {"segments_outdated", c.segments_outdated}};
  }

  CoreMemory memory() const override {
    CoreMemory m;
    segcal_memory(&m.state_bytes, &m.segment_bytes, &m.workspace_bytes);
    return m;
  }

 private:
  static FrameOutcome outcome(int code) {
    switch (code) {
      case SEGCAL_TRACKING: return FrameOutcome::tracking;
      case SEGCAL_SKIPPED: return FrameOutcome::skipped;
      case SEGCAL_LOST: return FrameOutcome::lost;
      default: return code < 0 ? FrameOutcome::refused : FrameOutcome::waiting;
    }
  }

  int parameters() const {
    int n = 15;
    for (const CameraCalibration& c : options_.calibration.cameras) n += c.model == DistortionModel::fov ? 11 : 14;
    for (int e = 0; e < SEGCAL_EFFECTS; ++e) {
      segcal_effect_t effect;
      if ((options_.effects >> e & 1u) != 0 && segcal_get_effect(e, &effect) == SEGCAL_OK) n += effect.n_parameters;
    }
    return n + static_cast<int>(options_.terms.size());
  }

  static CoreDirection direction(const segcal_direction_t& d, int n) {
    return {std::vector<double>(d.weight, d.weight + n), d.relative_sigma};
  }

  CoreKept kept_slot(int slot, const segcal_segment_t& s) const {
    CoreKept kept;
    kept.segment = segment_of(s);
    std::vector<segcal_state_t> states(s.keyframes);
    states.resize(std::max(0, segcal_get_keyframes(device_, slot, states.data(), s.keyframes)));
    for (const segcal_state_t& x : states) kept.keyframes.push_back(state_of(x));
    std::vector<segcal_point_residual_t> points(s.points);
    points.resize(std::max(0, segcal_get_point_residuals(device_, slot, points.data(), s.points)));
    for (const segcal_point_residual_t& r : points) kept.points.push_back({r.t_ns, r.camera, r.u, r.v});
    std::vector<segcal_imu_residual_t> imu(s.keyframes);
    imu.resize(std::max(0, segcal_get_imu_residuals(device_, slot, imu.data(), s.keyframes)));
    for (const segcal_imu_residual_t& r : imu) {
      kept.imu.push_back({r.t_ns, Eigen::Vector3d(r.rotation[0], r.rotation[1], r.rotation[2]),
                          Eigen::Vector3d(r.velocity[0], r.velocity[1], r.velocity[2]),
                          Eigen::Vector3d(r.position[0], r.position[1], r.position[2])});
    }
    add_measurements(slot, s, &kept);
    return kept;
  }

  /// What the calibration had of a segment.
  void add_measurements(int slot, const segcal_segment_t& s, CoreKept* kept) const {
    segcal_link_t link{};
    if (segcal_get_link(device_, slot, &link) == SEGCAL_OK) {
      static const char* const kJoin[] = {"none", "imu", "bias"};
      kept->place = link.place;
      kept->join = kJoin[link.join];
      kept->gap_s = link.gap_s;
      kept->lead_ns = link.lead_ns;
      kept->turned_only = link.turned_only != 0;
    }
    std::vector<segcal_landmark_t> landmarks(s.landmarks);
    landmarks.resize(std::max(0, segcal_get_landmarks(device_, slot, landmarks.data(), s.landmarks)));
    for (const segcal_landmark_t& l : landmarks) {
      kept->landmarks.push_back({l.track_id, l.tie, Eigen::Vector3d(l.anchor[0], l.anchor[1], l.anchor[2]),
                                 Eigen::Vector3d(l.direction[0], l.direction[1], l.direction[2]), l.inverse_distance});
    }
    std::vector<segcal_measured_point_t> points(s.points);
    points.resize(std::max(0, segcal_get_points(device_, slot, points.data(), s.points)));
    for (const segcal_measured_point_t& z : points) {
      kept->measured.push_back({z.landmark, z.keyframe, z.camera, z.u, z.v, z.rejected != 0});
    }
    std::vector<segcal_imu_t> samples(SEGCAL_MAX_IMU_SAMPLES);
    samples.resize(std::max(0, segcal_get_samples(device_, slot, samples.data(), SEGCAL_MAX_IMU_SAMPLES)));
    for (const segcal_imu_t& z : samples) {
      kept->samples.push_back({z.t_ns, {z.gyro[0], z.gyro[1], z.gyro[2]}, {z.accel[0], z.accel[1], z.accel[2]}, 0});
    }
  }

  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  CoreOptions options_;
  std::unique_ptr<void, Free> storage_;
  segcal_t* device_ = nullptr;
  std::vector<segcal_point_t> points_;
  FrameOutcome last_outcome_ = FrameOutcome::waiting;
  bool seen_ = false;
  std::uint32_t last_serial_ = 0;
};

}  // namespace SEGCAL_NS

std::unique_ptr<Core> SEGCAL_FACTORY(const CoreOptions& options) {
  return std::make_unique<SEGCAL_NS::ProfileCore>(options);
}

}  // namespace host
