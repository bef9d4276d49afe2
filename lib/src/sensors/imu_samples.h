// Integration over a stored sequence of samples, for any container with size(), time(i) (ticks) and reading(i).
#pragma once

#include <cstdint>

#include "math/resumable.h"
#include "sensors/imu_integral.h"

namespace SEGCAL_NS {

/// Last sample with time <= t; t must not lie before the first one.
template <class Samples, class Time>
int at_or_before(const Samples& samples, Time t) {
  int low = 0, high = samples.size() - 1;
  while (low < high) {
    const int middle = (low + high + 1) / 2;
    if (samples.time(middle) <= t) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  return low;
}

/// Sample i with the trapezoidal rule's error taken out beforehand: x_i - (x_{i+1} - 2 x_i + x_{i-1}) / 12. Summed by
/// trapezoids these give Euler and Maclaurin's corrected rule, fourth order in the sampling period; summed raw samples
/// lose (2 pi f dt)^2 / 12 of a motion at frequency f, 8e-5 at 1 Hz and 200 Hz, which would pass for gyroscope scale.
/// Samples at the ends, and beside an uneven period, stay as they are.
template <class S, class Samples>
InertialReading<S> corrected_reading(const Samples& samples, int i) {
  const InertialReading<S>& x = samples.reading(i);
  if (i == 0 || i + 1 >= samples.size()) return x;
  const S before = S(samples.time(i) - samples.time(i - 1)), after = S(samples.time(i + 1) - samples.time(i));
  if (absolute(before - after) > S(0.1) * before) return x;
  const InertialReading<S>& a = samples.reading(i - 1);
  const InertialReading<S>& b = samples.reading(i + 1);
  const S twelfth = S(1) / S(12);
  return {x.gyro - twelfth * ((b.gyro - x.gyro) - (x.gyro - a.gyro)),
          x.accel - twelfth * ((b.accel - x.accel) - (x.accel - a.accel))};
}

/// The reading at t by linear interpolation; t must lie within the samples.
template <class S, class Samples, class Time>
InertialReading<S> reading_at(const Samples& samples, Time t) {
  const int i = at_or_before(samples, t);
  if (samples.time(i) == t || i + 1 == samples.size()) return corrected_reading<S>(samples, i);
  const S u = S(t - samples.time(i)) / S(samples.time(i + 1) - samples.time(i));
  return interpolate<S>(corrected_reading<S>(samples, i), corrected_reading<S>(samples, i + 1), u);
}

/// Slope of the gyroscope's reading at sample i, rad/s per tick: the parabola through it and its neighbours, at the
/// ends through the three last.
template <class S, class Samples>
Vec3<S> gyro_slope(const Samples& samples, int i) {
  const int last = samples.size() - 1;
  if (last < 2) return Vec3<S>::Zero();
  const int m = i < 1 ? 1 : i < last ? i : last - 1;
  const S before = S(samples.time(m) - samples.time(m - 1)), after = S(samples.time(m + 1) - samples.time(m));
  const Vec3<S> a = (samples.reading(m).gyro - samples.reading(m - 1).gyro) / before;
  const Vec3<S> b = (samples.reading(m + 1).gyro - samples.reading(m).gyro) / after;
  const Vec3<S> bend = (b - a) / (before + after);  // half the second derivative
  return a + before * bend + S(2) * S(samples.time(i) - samples.time(m)) * bend;
}

/// The same at t, within the samples.
template <class S, class Samples, class Time>
Vec3<S> gyro_slope_at(const Samples& samples, Time t) {
  const int i = at_or_before(samples, t);
  const Vec3<S> a = gyro_slope<S>(samples, i);
  if (samples.time(i) == t || i + 1 == samples.size()) return a;
  const S u = S(t - samples.time(i)) / S(samples.time(i + 1) - samples.time(i));
  return a + u * (gyro_slope<S>(samples, i + 1) - a);
}

/// What terms need to know about a stretch of samples. Warmth and time are linear in between.
template <class S>
struct Stretch {
  S warmth0 = S(0), warmth1 = S(0);  ///< degC above 25
  S time0 = S(0), time1 = S(0);      ///< s since the device's first sample
  const Mat3<S>* R_GI = nullptr;     ///< at its beginning, or somewhere in it; null: nobody asks
  bool begins_there = true;          ///< false: the rotation since is not known, the heading is that of R_GI

  /// Cosine and sine of the heading of I's x axis, x_I0 in the axes of I at the beginning; zero where it stands
  /// upright. G's x axis is where the session began: a device cannot tell more. What a term changes by way of the
  /// heading is of second order and not derived.
  Vec2<S> heading(const Vec3<S>& x_I0) const {
    if (!R_GI) return Vec2<S>::Zero();
    S x[2];
    for (int i = 0; i < 2; ++i) {
      const S* r = R_GI->data() + i;  // column by column
      x[i] = begins_there ? r[0] * x_I0(0) + r[3] * x_I0(1) + r[6] * x_I0(2) : r[0];
    }
    const S squared = x[0] * x[0] + x[1] * x[1], scale = squared > S(1e-4) ? S(1) / square_root(squared) : S(0);
    return {scale * x[0], scale * x[1]};
  }
};

/// What is beside a reading that comes dt seconds from now, at the
/// share u of the stretch. One copy in the code for all samples.
template <class S>
void set_surroundings(const Stretch<S>& stretch, S u, const Vec3<S>& slope, S dt, ImuIntegrator<S>* integrator) {
  Surroundings<S>* out = integrator->surroundings();
  out->slope = slope;
  out->warmth = stretch.warmth0 + u * (stretch.warmth1 - stretch.warmth0);
  out->time = stretch.time0 + u * (stretch.time1 - stretch.time0);
  out->heading = stretch.heading(integrator->x_axis_after(dt));
}

/// Integrates from t0 to t1 > t0; both must lie within the samples. `tick_s`: seconds per tick.
template <class S, class Time>
class SampleIntegration {
 public:
  /// In slices of kSamples; true when the integrator has it all.
  template <class Samples>
  bool step(const Samples& samples, Time t0, Time t1, S tick_s, ImuIntegrator<S>* integrator,
            const Stretch<S>& stretch) {
    const bool beside = integrator->wants_surroundings();
    const auto set = [&](const Vec3<S>& slope_per_tick, Time t) {
      set_surroundings<S>(stretch, S(t - t0) / S(t1 - t0), slope_per_tick / tick_s, S(t - t_) * tick_s, integrator);
    };
    SEGCAL_SLICES(place_) {
      t_ = t0;
      if (beside) set(gyro_slope_at<S>(samples, t0), t0);
      integrator->start(reading_at<S>(samples, t0));
      left_ = kSamples;
      for (i_ = at_or_before(samples, t0) + 1; i_ < samples.size() && samples.time(i_) < t1; ++i_) {
        if (beside) set(gyro_slope<S>(samples, i_), samples.time(i_));
        integrator->step(corrected_reading<S>(samples, i_), S(samples.time(i_) - t_) * tick_s);
        t_ = samples.time(i_);
        if (--left_ > 0) continue;
        left_ = kSamples;
        SEGCAL_PAUSE(place_);
        i_ = at_or_before(samples, t_);  // in a ring that has moved on it stands elsewhere now
      }
      if (beside) set(gyro_slope_at<S>(samples, t1), t1);
      integrator->step(reading_at<S>(samples, t1), S(t1 - t_) * tick_s);
    }
    SEGCAL_SLICES_END(place_);
  }
  void restart() { place_ = 0; }

 private:
  static constexpr int kSamples = 12;
  Place place_ = 0;
  std::int32_t i_ = 0, left_ = 0;
  Time t_ = Time(0);
};

/// The same at once.
template <class S, class Samples, class Time>
void integrate_samples(const Samples& samples, Time t0, Time t1, S tick_s, ImuIntegrator<S>* integrator,
                       const Stretch<S>& stretch = {}) {
  SampleIntegration<S, Time> integration;
  while (!integration.step(samples, t0, t1, tick_s, integrator, stretch)) {
  }
}

}  // namespace SEGCAL_NS
