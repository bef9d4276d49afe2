// What the IMU's readings say without the filter: do they rest?
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

}  // namespace SEGCAL_NS
