// The noise of an IMU's readings as they show it, without a model of the motion.
//
// A motion that the samples resolve is smooth: its sixth difference is (2 sin(pi f dt))^6 of it, 1e-3 at 5 Hz and 100
// Hz, where that of white noise has sqrt(924) = 30 times the noise's standard deviation (924: the sum of the binomial
// weights' squares). What is left is the sensor's noise and what the samples cannot follow: rotors, a rattle, a blow.
// None of it averages out as the stated noise would. A filter that takes the stated noise for it believes a wrong
// velocity; a calibration pays for it with the accelerometer's scale, since J = dr / ds holds the same samples as r
// (docs/results.md, "Rough IMUs").
//
// The differences are taken of means over 10 ms and one sample more, and the smaller answer counts. Close to half the
// rate of a fast sensor, where differences of its samples look, it filters, so that noise seems less than it is; and a
// tone seems to be noise, though its integral stays bounded. A tone that one of the two kinds of means lets pass the
// other one stops. The worst axis counts for all three.
#pragma once

#include "sensors/imu_samples.h"

namespace SEGCAL_NS {

/// Sixth differences of means that come one by one: each new one takes a difference further in all six orders.
template <class S>
class SixthDifferences {
 public:
  /// Means of `group` of the readings [first, last].
  template <class Samples>
  [[gnu::cold, gnu::noinline]] void take(const Samples& imu, int first, int last, int group) {
    for (int i = first; i + group - 1 <= last; i += group) {
      InertialReading<S> sum = imu.reading(i);
      for (int k = 1; k < group; ++k) {
        const InertialReading<S>& next = imu.reading(i + k);
        sum.gyro += next.gyro;
        sum.accel += next.accel;
      }
      push(sum, S(1) / S(group));
    }
  }
  /// At least nine means, three differences: fewer tell too little.
  bool enough() const { return count_ >= 9; }
  /// Standard deviation squared of the means, of the worst axis.
  S gyro_variance() const { return worst(0); }
  S accel_variance() const { return worst(3); }

 private:
  static constexpr int kOrder = 6;
  [[gnu::cold, gnu::noinline]] void push(const InertialReading<S>& sum, S share) {
    ++count_;
    for (int i = 0; i < 6; ++i) {
      S difference = share * (i < 3 ? sum.gyro(i) : sum.accel(i - 3));
      for (S& last : last_[i]) {
        const S before = last;
        last = difference;
        difference -= before;
      }
      if (count_ > kOrder) square_[i] += difference * difference;
    }
  }
  S worst(int first) const {
    const S a = square_[first], b = square_[first + 1], c = square_[first + 2], ab = a > b ? a : b;
    return (ab > c ? ab : c) / (S(924) * S(count_ - kOrder));
  }
  int count_ = 0;
  S square_[6] = {};
  S last_[6][kOrder] = {};  // of each axis: the newest difference of each order, from the reading itself on
};

/// Density with what the readings have beyond it. A short stretch
/// of white noise may look half as large again by chance.
template <class S>
S rougher_density(S density, S variance, S interval) {
  const S seen = variance * interval, expected = S(2.25) * density * density;
  return seen > expected ? square_root(density * density + seen - expected) : density;
}

/// The noise of readings [first, last], `interval` seconds apart, in
/// means of `least` and one more: as stated or as rough as they are.
template <class S, class Samples>
[[gnu::cold]] ImuNoise<S> noise_of(const Samples& imu, const ImuNoise<S>& stated, int first, int last, S interval,
                                   int least) {
  ImuNoise<S> out = stated;
  for (int group = least; group <= least + 1; ++group) {
    SixthDifferences<S> rough;
    rough.take(imu, first, last, group);
    if (!rough.enough()) break;
    const S gyro = rougher_density(stated.gyro, rough.gyro_variance(), S(group) * interval);
    const S accel = rougher_density(stated.accel, rough.accel_variance(), S(group) * interval);
    if (group == least || gyro < out.gyro) out.gyro = gyro;
    if (group == least || accel < out.accel) out.accel = accel;
    if (out.gyro == stated.gyro && out.accel == stated.accel) break;  // no answer is smaller
  }
  return out;
}

/// Means that are looked at, around a link too: with a third of them the
/// worst of three axes would be too large by chance once in ten links.
constexpr int kRoughMeans = 48;

/// The noise between two times in ticks of `tick_s` seconds, from the
/// samples there and around. Container: size(), time(i), reading(i).
template <class S, class Samples, class Time>
[[gnu::cold]] ImuNoise<S> noise_in(const Samples& imu, const ImuNoise<S>& stated, Time t0, Time t1, S tick_s) {
  int first = at_or_before(imu, t0), last = at_or_before(imu, t1);
  if (last <= first) return stated;
  const S interval = S(imu.time(last) - imu.time(first)) * tick_s / S(last - first);
  if (!(interval > S(1e-5))) return stated;  // no sensor is as fast: stamps of one instant
  const int least = interval < S(0.01) ? int(S(0.01) / interval + S(0.5)) : 1;
  const int beside = (kRoughMeans * (least + 1) - (last - first)) / 2;
  if (beside > 0) {
    first = first > beside ? first - beside : 0;
    last = last + beside < imu.size() ? last + beside : imu.size() - 1;
  }
  return noise_of(imu, stated, first, last, interval, least);
}

}  // namespace SEGCAL_NS
