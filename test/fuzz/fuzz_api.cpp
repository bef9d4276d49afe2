// Any sequence of calls of the C API, with data of any kind: bytes become calls. A
// realistic session is fed in between, so that segments, scores and calibrations are
// reached, and what is mutated are its samples, its images and the configuration.
#include <segcal/health.h>
#include <segcal/segcal.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "../support/synthetic_stream.h"
#include "fuzz_bytes.h"

namespace {

using test::SyntheticStream;

const SyntheticStream& stream() {
  static const SyntheticStream instance(3, 24);
  return instance;
}

class Session {
 public:
  explicit Session(FuzzBytes* bytes) : in_(*bytes), storage_(segcal_storage_bytes() / sizeof(std::max_align_t) + 1) {}

  void run() {
    segcal_config_t config = SyntheticStream::config();
    config.estimate_effects = in_.flag() ? std::uint32_t(SEGCAL_EFFECT_TIME_OFFSET) : 0u;
    config.metric = in_.below(5);
    config.condense = SEGCAL_MAX_EPOCHS > 0 && in_.flag() ? 1 : 0;
    for (int n = in_.below(8) - 5; n > 0; --n) in_.spoil(&config);  // three of eight sessions
    if (segcal_create(&device_, &config, storage_.data(), storage_.size() * sizeof(std::max_align_t)) != SEGCAL_OK)
      return;
    while (!in_.empty()) step();
    segcal_flush(device_);
    segcal_calibrate(device_);
    ask();
  }

 private:
  void step() {
    switch (in_.below(12)) {
      case 0:
      case 1:
      case 2:
      case 3: return feed(1 + in_.below(250));
      case 4: return sample(true);
      case 5: return image(true);
      case 6: return ask();
      case 7: segcal_background(device_, in_.below(40)); return;
      case 8: return flush(in_.below(8));
      case 9:
        if (in_.below(4) == 0) segcal_calibrate(device_);
        return;
      case 10:
        if (in_.below(6) == 0) segcal_new_session(device_);
        return;
      default: shift_ns_ = in_.below(3) == 0 ? in_.integer() : shift() + in_.below(100) * 1000000; return;
    }
  }

  void flush(int how) {
    if (how < 2) segcal_flush(device_);
    if (how == 2) segcal_flush_slices(device_, in_.below(400));
    if (how == 3) segcal_request_calibration(device_);
    if (how == 4) segcal_work_when_due(device_, in_.flag() ? 1 : 0);
  }

  /// The next samples as they are, and their images.
  void feed(int samples) {
    const int slices = in_.below(20);
    for (int i = 0; i < samples; ++i) {
      sample(false);
      if (next_ % 20 == 0) image(false);
      segcal_background(device_, slices);
    }
  }

  void sample(bool spoilt) {
    segcal_imu_t s = stream().imu[next_++ % stream().imu.size()];
    s.t_ns += shift() + std::int64_t(next_ / stream().imu.size()) * 24000000000;
    if (spoilt) in_.spoil(&s);
    segcal_push_imu(device_, &s);
  }

  void image(bool spoilt) {
    const SyntheticStream::Frame& frame = stream().frames[next_ / 20 % stream().frames.size()];
    std::vector<segcal_point_t> points = frame.points;
    segcal_state_t state = frame.state;
    state.t_ns += shift() + std::int64_t(next_ / stream().imu.size()) * 24000000000;
    if (spoilt) {
      for (int n = in_.below(20); n > 0; --n) in_.spoil(&points[std::size_t(in_.below(int(points.size())))]);
      const std::uint32_t modulus = 1u + std::uint32_t(in_.below(97));
      if (in_.flag())
        for (segcal_point_t& p : points) p.track_id %= modulus;
      if (in_.flag()) in_.spoil(&state);
    }
    const std::int32_t n = std::int32_t(points.size()) - (spoilt ? in_.below(80) - 10 : 0);
    const std::int32_t most = std::min(std::int32_t(points.size()), std::int32_t(SEGCAL_MAX_TRACKS));
    const std::int32_t count = n > most ? most : n;
    if (spoilt && in_.flag()) {
      segcal_push_keyframe(device_, &state, points.data(), count);
    } else {
      segcal_push_tracks(device_, state.t_ns, points.data(), count);
    }
  }

  /// Stamps may be anything, but the sum must not overflow here.
  std::int64_t shift() const { return shift_ns_ % (std::int64_t(1) << 61); }

  void ask() {
    static std::vector<unsigned char> out(1 << 20);
    const auto as = [&](auto* p) { return reinterpret_cast<decltype(p)>(out.data()); };
    const int slot = in_.below(SEGCAL_MAX_SEGMENTS + 4) - 1, capacity = in_.below(70) - 2;
    segcal_get_result(device_, as((segcal_result_t*)nullptr));
    segcal_get_filter_calibration(device_, as((segcal_result_t*)nullptr));
    segcal_get_state(device_, as((segcal_state_t*)nullptr));
    segcal_get_counters(device_, as((segcal_counters_t*)nullptr));
    segcal_get_segment(device_, slot, as((segcal_segment_t*)nullptr));
    segcal_get_direction(device_, slot, as((segcal_direction_t*)nullptr));
    segcal_get_keyframes(device_, slot, as((segcal_state_t*)nullptr), capacity);
    segcal_get_landmarks(device_, slot, as((segcal_landmark_t*)nullptr), capacity);
    segcal_get_points(device_, slot, as((segcal_measured_point_t*)nullptr), capacity);
    segcal_get_samples(device_, slot, as((segcal_imu_t*)nullptr), capacity);
    segcal_get_point_residuals(device_, slot, as((segcal_point_residual_t*)nullptr), capacity);
    segcal_get_imu_residuals(device_, slot, as((segcal_imu_residual_t*)nullptr), capacity);
    segcal_get_link(device_, slot, as((segcal_link_t*)nullptr));
    segcal_get_segment_directions(device_, as((segcal_direction_t*)nullptr), capacity);
    segcal_get_segment_sigmas(device_, as((double*)nullptr), capacity);
    segcal_get_effect_scores(device_, as((segcal_effect_score_t*)nullptr), capacity);
    segcal_get_model(device_, as((segcal_model_t*)nullptr));
    segcal_get_camera(device_, slot, as((segcal_camera_t*)nullptr));
    segcal_get_imu_calibration(device_, as((segcal_imu_calibration_t*)nullptr));
    segcal_get_epoch(device_, slot, as((segcal_epoch_t*)nullptr));
    segcal_get_history(device_, slot, as((segcal_epoch_t*)nullptr));
    segcal_get_course(device_, as((segcal_course_t*)nullptr));
    segcal_progress(device_, as((segcal_progress_t*)nullptr));
    segcal_health_words(segcal_get_health(device_));
    segcal_result_hash(device_);
    ask_for_arrays(capacity);
  }

  /// Their capacities are what they are, or too small.
  void ask_for_arrays(int capacity) {
    static std::vector<double> mean(SEGCAL_MAX_PARAMETERS), covariance(SEGCAL_MAX_PARAMETERS * SEGCAL_MAX_PARAMETERS);
    segcal_get_posterior(device_, mean.data(), covariance.data(),
                         in_.flag() ? capacity : std::int32_t(covariance.size()));
    segcal_term_t term[SEGCAL_MAX_EFFECT_ESTIMATES + 1];
    double value[SEGCAL_MAX_EFFECT_ESTIMATES + 1];
    segcal_get_terms(device_, term, value,
                     capacity < SEGCAL_MAX_EFFECT_ESTIMATES ? capacity : SEGCAL_MAX_EFFECT_ESTIMATES);
    if (in_.below(4) == 0) linearise();
  }

  /// With candidates of the catalogue, some of them spoilt.
  void linearise() {
    std::vector<std::uint8_t> use(SEGCAL_MAX_SEGMENTS + 1);
    for (std::uint8_t& slot : use) slot = in_.flag() ? 1 : 0;
    std::vector<segcal_term_t> candidates(SEGCAL_MAX_EFFECT_COLUMNS + 16);
    int n = 0;
    for (int effects = in_.below(4); effects > 0 && n <= SEGCAL_MAX_EFFECT_COLUMNS; --effects) {
      const int terms = segcal_effect_terms(in_.below(20) - 1, &candidates[std::size_t(n)]);
      n += terms > 0 ? terms : 0;
    }
    if (n > 0 && in_.below(3) == 0) in_.spoil(&candidates[std::size_t(in_.below(n))]);
    segcal_parameter_t description;
    for (int i = 0; i < n; ++i) segcal_describe_term(&candidates[std::size_t(i)], &description);
    const std::size_t columns = SEGCAL_MAX_PARAMETERS + SEGCAL_MAX_EFFECT_COLUMNS + 1;
    static std::vector<double> triangle(columns * (columns + 1) / 2);
    std::int32_t n_theta, n_terms, dof;
    segcal_linearise(device_, use.data(), candidates.data(), n, triangle.data(), std::int32_t(triangle.size()),
                     &n_theta, &n_terms, &dof);
  }

  FuzzBytes& in_;
  std::vector<std::max_align_t> storage_;
  segcal_t* device_ = nullptr;
  std::size_t next_ = 0;
  std::int64_t shift_ns_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzBytes bytes(data, size);
  Session(&bytes).run();
  return 0;
}
