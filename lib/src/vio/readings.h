// What the IMU's readings say without the filter: do they rest, and are they rougher than their stated noise?
#pragma once

#include "sensors/imu_history.h"

namespace SEGCAL_NS {

/// Mean and spread of the readings in a stretch of time.
template <class S>
struct ReadingSpread {
  InertialReading<S> mean;
  S gyro, accel;  ///< standard deviation, of the worst axis
  int samples;
};

template <class S>
ReadingSpread<S> reading_spread(const ImuHistory<S>& imu, std::int64_t t0, std::int64_t t1) {
  ReadingSpread<S> out;
  const int first = imu.at_or_before(t0), last = imu.at_or_before(t1);
  out.samples = last - first + 1;
  Vec3<S> gyro = Vec3<S>::Zero(), accel = Vec3<S>::Zero(), gyro2 = gyro, accel2 = accel;
  for (int i = first; i <= last; ++i) {
    gyro += imu.reading(i).gyro;
    accel += imu.reading(i).accel;
  }
  out.mean = {gyro / S(out.samples), accel / S(out.samples)};
  for (int i = first; i <= last; ++i) {
    gyro2 += (imu.reading(i).gyro - out.mean.gyro).cwiseAbs2();
    accel2 += (imu.reading(i).accel - out.mean.accel).cwiseAbs2();
  }
  out.gyro = square_root(gyro2.maxCoeff() / S(out.samples));
  out.accel = square_root(accel2.maxCoeff() / S(out.samples));
  return out;
}

/// White noise that the readings [first, last] seem to have, standard deviation squared per axis: of their third
/// differences, which are next to nothing for a motion that the samples resolve. The binomial weights' squares add to 20.
template <class S, class Samples>
InertialReading<S> roughness2(const Samples& imu, int first, int last) {
  InertialReading<S> sum{Vec3<S>::Zero(), Vec3<S>::Zero()};
  for (int i = first; i + 3 <= last; ++i) {
    const InertialReading<S>&a = imu.reading(i), &b = imu.reading(i + 1), &c = imu.reading(i + 2), &d = imu.reading(i + 3);
    sum.gyro += (d.gyro - a.gyro + S(3) * (b.gyro - c.gyro)).cwiseAbs2();
    sum.accel += (d.accel - a.accel + S(3) * (b.accel - c.accel)).cwiseAbs2();
  }
  const S weight = S(1) / (S(20) * S(last - first - 2));
  return {weight * sum.gyro, weight * sum.accel};
}

/// Density with what the readings have beyond it. A short stretch of white noise may look half as large again by chance.
template <class S>
S rougher_density(S density, S variance, S interval) {
  const S seen = variance * interval, expected = S(2.25) * density * density;
  return seen > expected ? square_root(density * density + seen - expected) : density;
}

/// Noise in [t0, t1]. A blow or motors that rattle move the IMU faster than its samples can follow: what they miss does
/// not average out, and a filter that takes the stated noise for it believes a wrong velocity.
template <class S, class Samples>
ImuNoise<S> noise_in(const Samples& imu, const ImuNoise<S>& stated, std::int64_t t0, std::int64_t t1) {
  const int first = imu.at_or_before(t0), last = imu.at_or_before(t1);
  ImuNoise<S> out = stated;
  if (last - first < 8) return out;
  const InertialReading<S> rough = roughness2<S>(imu, first, last);
  const S interval = S(imu.time(last) - imu.time(first)) * S(1e-9) / S(last - first);
  out.gyro = rougher_density(stated.gyro, rough.gyro.sum() / S(3), interval);
  out.accel = rougher_density(stated.accel, rough.accel.sum() / S(3), interval);
  return out;
}

}  // namespace SEGCAL_NS
