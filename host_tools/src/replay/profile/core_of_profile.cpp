// The C API of one profile behind host::Core. Compiled once per profile; all names that depend on capacities are in
// that profile's own namespace.
#include <segcal/health.h>

#include <cstdlib>
#include <cstring>

#include "replay/profile/config_of_profile.h"
#include "replay/profile/read_device.h"
#include "replay/profile/sensor_rows_of_profile.h"
#include "replay/profile/side_of_profile.h"
#include "replay/profile/store_of_profile.h"

namespace host {
namespace SEGCAL_NS {

class ProfileCore final : public Core {
 public:
  explicit ProfileCore(const CoreOptions& options) : options_(options) {
    const segcal_config_t config = config_of(options);
    const std::size_t bytes =
        (segcal_storage_bytes() + SEGCAL_STORAGE_ALIGNMENT - 1) / SEGCAL_STORAGE_ALIGNMENT * SEGCAL_STORAGE_ALIGNMENT;
    storage_.reset(std::aligned_alloc(SEGCAL_STORAGE_ALIGNMENT, bytes));
    const int error = segcal_create(&device_, &config, storage_.get(), bytes);
    if (error != SEGCAL_OK) {
      throw InputError("the core refuses this configuration (error " + std::to_string(error) +
                       "): check focal length, distortion and noise values of the calibration");
    }
    segcal_work_when_due(device_, 1);
  }

  void push_imu(const ImuSample& sample) override {
    const segcal_imu_t s = sample_to_c(sample);
    last_outcome_ = outcome(segcal_push_imu(device_, &s));
  }

  FrameOutcome push_frame(std::int64_t t_ns, const std::vector<const Frame*>& per_camera) override {
    points_to_c(per_camera, &points_);
    return outcome(segcal_push_tracks(device_, t_ns, points_.data(), static_cast<int>(points_.size())));
  }

  bool state(CoreState* out) const override {
    segcal_state_t s;
    if (segcal_get_state(device_, &s) != SEGCAL_OK) return false;
    *out = state_of(s);
    return true;
  }

  bool background() override {
    if (works_ahead_) segcal_background(device_, INT32_MAX);
    return published_calibrations() != seen_calibrations_ && (seen_calibrations_ = published_calibrations()) > 0;
  }
  void work_ahead(bool ahead) override { works_ahead_ = ahead; }
  void be_late(bool late) override { segcal_work_when_due(device_, late ? 0 : 1); }
  void request_calibration() override { segcal_request_calibration(device_); }
  void flush() override { segcal_flush(device_); }
  void new_session() override { segcal_new_session(device_); }
  bool calibrate() override {
    const bool done = segcal_calibrate(device_) >= 0;
    seen_calibrations_ = published_calibrations();
    return done;
  }

  bool has_result() const override {
    segcal_result_t r;
    return segcal_get_result(device_, &r) == SEGCAL_OK;
  }

  CoreResult result() const override { return result_of(device_); }

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
    for (int i = 0; i < n; ++i) out->not_excited.push_back(direction_of(directions[i], parameters()));
    out->sigma.resize(SEGCAL_MAX_PARAMETERS);
    out->sigma.resize(std::max(0, segcal_get_segment_sigmas(device_, out->sigma.data(), SEGCAL_MAX_PARAMETERS)));
    return true;
  }

  std::vector<CoreKept> kept() const override {
    std::vector<CoreKept> out;
    for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
      segcal_segment_t s;
      if (segcal_get_segment(device_, slot, &s) != SEGCAL_OK || !s.kept) continue;
      out.push_back(kept_of(device_, slot, s));
    }
    return out;
  }

  CoreModel model() const override {
    segcal_model_t m{};
    segcal_get_model(device_, &m);
    return {m.gyro_noise_density,
            m.gyro_random_walk,
            m.accel_noise_density,
            m.accel_random_walk,
            m.gravity,
            m.pixel_sigma,
            m.huber,
            m.bias_a_sigma,
            m.bias_g_sigma,
            m.velocity_sigma,
            m.inverse_depth_sigma,
            m.turned_inverse_depth_sigma,
            m.track_walk,
            SEGCAL_TRACK_WALK != 0};
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
    if (error != SEGCAL_OK)
      throw InputError("the core does not linearise these segments and effects (error " + std::to_string(error) + ")");
    out.n_theta = n_theta;
    out.n_candidates = n_terms;
    out.dof = dof;
    return out;
  }

  CoreSensorRows sensor_rows(std::uint32_t serial, const std::vector<CoreTerm>& candidates) override {
    for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
      segcal_segment_t s;
      if (segcal_get_segment(device_, slot, &s) == SEGCAL_OK && s.kept && s.serial == serial)
        return sensor_rows_of(device_, slot, candidates);
    }
    throw InputError("the core keeps no segment " + std::to_string(serial));
  }

  std::unique_ptr<CoreSide> side(const std::vector<std::uint32_t>& serials,
                                 const std::vector<double>& expected) const override {
    return side_of(*core::open(device_), serials, expected);
  }

  std::vector<std::uint32_t> outdated() const override {
    std::vector<std::uint32_t> out;
    for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
      segcal_segment_t s;
      if (segcal_get_segment(device_, slot, &s) == SEGCAL_OK && s.outdated) out.push_back(s.serial);
    }
    return out;
  }

  std::string trouble() const override {
    const int health = segcal_get_health(device_);
    return health <= SEGCAL_HEALTH_RUNNING || health == SEGCAL_HEALTH_STARTING ? "" : segcal_health_words(health);
  }
  std::vector<std::pair<std::string, std::uint32_t>> counters() const override { return counters_of(device_); }

  void restore(FlashImage* flash) override {
    restore_device(device_, flash);
    seen_calibrations_ = published_calibrations();
  }
  void save(FlashImage* flash) override { save_device(device_, flash); }
  std::uint64_t result_hash() const override { return segcal_result_hash(device_); }

  std::uint32_t work() const override {
    segcal_progress_t progress;
    segcal_progress(device_, &progress);
    return progress.slices;
  }

  CoreMemory memory() const override {
    CoreMemory m;
    segcal_memory(&m.state_bytes, &m.segment_bytes, &m.workspace_bytes);
    return m;
  }

 private:
  std::uint32_t published_calibrations() const {
    segcal_counters_t c{};
    segcal_get_counters(device_, &c);
    return c.calibrations_published;
  }

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

  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  CoreOptions options_;
  std::unique_ptr<void, Free> storage_;
  segcal_t* device_ = nullptr;
  std::vector<segcal_point_t> points_;
  FrameOutcome last_outcome_ = FrameOutcome::waiting;
  bool seen_ = false, works_ahead_ = true;
  std::uint32_t last_serial_ = 0, seen_calibrations_ = 0;
};

std::unique_ptr<Core> make_core(const CoreOptions& options) { return std::make_unique<ProfileCore>(options); }

int most_segments() { return SEGCAL_MAX_SEGMENTS; }

}  // namespace SEGCAL_NS
}  // namespace host
