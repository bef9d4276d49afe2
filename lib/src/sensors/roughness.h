// The noise of an IMU's readings as they show it, without a model of the motion.
//
// A motion that the samples resolve is smooth: its sixth difference is (2 sin(pi f dt))^6 of it, 1e-3 at 5 Hz and 100 Hz, where that of
// white noise has sqrt(924) = 30 times the noise's standard deviation (924: the sum of the binomial weights' squares). What is left is
// the sensor's noise and what the samples cannot follow: rotors, a rattle, a blow. None of it averages out as the stated noise would.
// A filter that takes the stated noise for it believes a wrong velocity; a calibration pays for it with the accelerometer's scale, since
// J = dr / ds holds the same samples as r (docs/results.md, "Measured data").
#pragma once

#include "sensors/imu_samples.h"

namespace SEGCAL_NS {

/// Sixth differences of readings that come one by one: each new one takes a difference further in all six orders.
template <class S>
class SixthDifferences {
 public:
  void push(const InertialReading<S>& reading) {
    const S gyro = next(reading.gyro, 0), accel = next(reading.accel, 3);
    if (++count_ <= kOrder) return;
    gyro_ += gyro;
    accel_ += accel;
  }
  /// Standard deviation squared, mean of the axes; at least seven readings.
  S gyro_variance() const { return gyro_ / weight(); }
  S accel_variance() const { return accel_ / weight(); }

 private:
  static constexpr int kOrder = 6;
  S weight() const { return S(3 * 924) * S(count_ - kOrder); }
  S next(const Vec3<S>& reading, int first_axis) {
    S sum = S(0);
    for (int i = 0; i < 3; ++i) {
      S difference = reading(i);
      for (S& last : last_[first_axis + i]) {
        const S before = last;
        last = difference;
        difference -= before;
      }
      sum += difference * difference;
    }
    return sum;
  }
  int count_ = 0;
  S gyro_ = S(0), accel_ = S(0);
  S last_[6][kOrder] = {};   // of each axis: the newest difference of each order, from the reading itself on
};

/// Density with what the readings have beyond it. A short stretch of white noise may look half as large again by chance.
template <class S>
S rougher_density(S density, S variance, S interval) {
  const S seen = variance * interval, expected = S(2.25) * density * density;
  return seen > expected ? square_root(density * density + seen - expected) : density;
}

/// The noise between two times in ticks of `tick_s` seconds, as stated or as rough as the readings are. Fewer than nine tell too little.
template <class S, class Samples, class Time>
[[gnu::cold]] ImuNoise<S> noise_in(const Samples& imu, const ImuNoise<S>& stated, Time t0, Time t1, S tick_s) {
  const int first = at_or_before(imu, t0), last = at_or_before(imu, t1);
  ImuNoise<S> out = stated;
  if (last - first < 8) return out;
  SixthDifferences<S> rough;
  for (int i = first; i <= last; ++i) rough.push(imu.reading(i));
  const S interval = S(imu.time(last) - imu.time(first)) * tick_s / S(last - first);
  out.gyro = rougher_density(stated.gyro, rough.gyro_variance(), interval);
  out.accel = rougher_density(stated.accel, rough.accel_variance(), interval);
  return out;
}

}  // namespace SEGCAL_NS
