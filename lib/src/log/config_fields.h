// A configuration in a device log: its fields in the order of segcal_config_t, listed once for writing and reading.
//
// New fields are appended to the list. A shorter block, of an older writer, leaves them zero, which means their
// default; a longer one is refused, since what the device did with it is not known here.
#pragma once

#include "log/format.h"

namespace SEGCAL_NS {

/// Calls, not inlined: the list of fields is long, and firmware carries it.
class ConfigWriter {
 public:
  explicit ConfigWriter(ByteWriter* out) : out_(out) {}
  template <class T>
  [[gnu::noinline]] void integer(const T& value) {
    out_->integer(value);
  }
  [[gnu::noinline]] void number(const double& value) { out_->number(value); }
  [[gnu::noinline]] void numbers(const double* values, int n) {
    for (int i = 0; i < n; ++i) number(values[i]);
  }
  /// Entries of an array that depends on a capacity.
  std::int32_t count(std::int32_t capacity) {
    out_->integer(capacity);
    return capacity;
  }
  void sigmas(const double* values, std::int32_t n) { numbers(values, n); }

 private:
  ByteWriter* out_;
};

class ConfigReader {
 public:
  explicit ConfigReader(ByteReader* in) : in_(in) {}
  template <class T>
  void integer(T& value) {
    value = in_->integer<T>();
  }
  void number(double& value) { value = in_->number64(); }
  void numbers(double* values, int n) {
    for (int i = 0; i < n; ++i) values[i] = in_->number64();
  }
  std::int32_t count(std::int32_t) {
    const std::int32_t n = in_->integer<std::int32_t>();
    fits_ = fits_ && n >= 0 && n <= 1000;
    return fits_ ? n : 0;
  }
  /// Of a writer with other capacities: entries beyond ours must be zero.
  void sigmas(double* values, std::int32_t n) {
    for (std::int32_t i = 0; i < n; ++i) {
      const double value = in_->number64();
      if (i < SEGCAL_MAX_PARAMETERS) {
        values[i] = value;
      } else {
        fits_ = fits_ && value == 0;
      }
    }
  }
  bool fits() const { return fits_; }

 private:
  ByteReader* in_;
  bool fits_ = true;
};

/// Of a writer with other capacities: terms beyond ours are read and forgotten; n_terms must fit.
template <class Config, class Codec>
void term_fields(Config* c, std::int32_t terms, Codec* f) {
  segcal_term_t no_term = {};
  double no_value = 0;
  for (std::int32_t i = 0; i < terms; ++i) {
    auto* term = i < SEGCAL_MAX_EFFECT_ESTIMATES ? &c->term[i] : &no_term;
    f->integer(term->kind);
    f->integer(term->a);
    f->integer(term->b);
    f->integer(term->c);
    f->number(i < SEGCAL_MAX_EFFECT_ESTIMATES ? c->term_value[i] : no_value);
  }
}

/// `Config`: segcal_config_t, const to write it; so in all of these.
template <class Config, class Codec>
void calibration_fields(Config* c, Codec* f) {
  f->integer(c->n_cameras);
  const std::int32_t cameras = f->count(SEGCAL_MAX_CAMERAS);
  segcal_camera_t beyond = {};
  for (std::int32_t i = 0; i < cameras; ++i) {
    auto* camera = i < SEGCAL_MAX_CAMERAS ? &c->camera[i] : &beyond;  // read and forgotten: n_cameras must fit
    f->integer(camera->model);
    f->numbers(camera->q_CI, 4);
    f->numbers(camera->p_CI, 3);
    f->numbers(camera->intrinsics, 4);
    f->numbers(camera->distortion, 4);
    f->integer(camera->height);
  }
  f->numbers(c->imu.gyro_scale, 3);
  f->numbers(c->imu.gyro_misalignment, 3);
  f->numbers(c->imu.accel_scale, 3);
  f->numbers(c->imu.accel_misalignment, 3);
  f->numbers(c->imu.q_AI, 4);
}

template <class Config, class Codec>
void sensor_fields(Config* c, Codec* f) {
  f->number(c->imu_rate_hz);
  f->number(c->gyro_noise_density);
  f->number(c->gyro_random_walk);
  f->number(c->accel_noise_density);
  f->number(c->accel_random_walk);
  f->number(c->gyro_range);
  f->number(c->accel_range);
  f->number(c->pixel_sigma);
  f->number(c->gravity);
  f->number(c->frame_interval_s);
  f->number(c->segment_s);
  f->number(c->least_segment_s);
  f->number(c->most_segment_s);
}

template <class Config, class Codec>
void config_fields(Config* c, Codec* f) {
  calibration_fields(c, f);
  sensor_fields(c, f);
  f->integer(c->keep_segments);
  f->integer(c->metric);
  f->integer(c->strategy);
  f->number(c->least_gain_nats);
  const std::int32_t parameters = f->count(SEGCAL_MAX_PARAMETERS);
  f->sigmas(c->prior_sigma, parameters);
  f->sigmas(c->sigma_ref, parameters);
  f->number(c->filter_share);
  f->integer(c->seed);
  f->sigmas(c->trigger_sigma, parameters);
  f->number(c->trigger_fraction);
  f->integer(c->joint_filter);
  f->number(c->outdated_level);
  f->integer(c->estimate_effects);
  f->integer(c->n_terms);
  const std::int32_t terms = f->count(SEGCAL_MAX_EFFECT_ESTIMATES);
  term_fields(c, terms, f);
  f->integer(c->watch_effects);
  f->integer(c->has_temperature);
  f->number(c->track_walk);
  f->integer(c->calibration_window);
  f->integer(c->condense);
}

/// False if the bytes are no configuration that fits into these capacities.
inline bool read_config(const std::uint8_t* bytes, std::size_t size, segcal_config_t* out) {
  *out = segcal_config_t{};
  ByteReader in(bytes, size);
  ConfigReader reader(&in);
  config_fields(out, &reader);
  return reader.fits() && in.left() == 0 && out->n_cameras >= 0 && out->n_cameras <= SEGCAL_MAX_CAMERAS &&
         out->n_terms >= 0 && out->n_terms <= SEGCAL_MAX_EFFECT_ESTIMATES;
}

}  // namespace SEGCAL_NS
