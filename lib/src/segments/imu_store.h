// Raw IMU samples of one segment, 14 bytes each: 16-bit integers over the sensor's range, as most sensors give them,
// and the microseconds since the sample before.
//
// At the default ranges of 35 rad/s and 157 m/s^2 a step is 1.1e-3 rad/s and 4.8e-3 m/s^2; rounding adds 1.6 % and
// 0.03 % to the variance of a good MEMS sensor's samples at 200 Hz, twice that at 100 Hz. Values beyond the range are
// clipped (counted as saturation where they come in).
#pragma once

#include <cstdint>

#include "sensors/imu_samples.h"

namespace SEGCAL_NS {

constexpr int kStampsPerAnchor = 16;

template <class S>
std::int16_t pack_value(S value, S step) {
  const S limit = S(32767);
  const S scaled = value / step;
  if (!(scaled < limit)) return 32767;  // not-a-number too
  if (scaled <= -limit) return -32767;
  return static_cast<std::int16_t>(scaled + (scaled < S(0) ? S(-0.5) : S(0.5)));
}

template <class S>
struct StoredFields;  // store/stored_fields.h

template <class S>
class ImuStore {
  friend struct StoredFields<S>;

 public:
  /// Empties the store; ranges in rad/s and m/s^2.
  void clear(S gyro_range = S(35), S accel_range = S(157)) {
    count_ = 0;
    gyro_step_ = gyro_range / S(32767);
    accel_step_ = accel_range / S(32767);
  }
  int size() const { return count_; }
  bool full() const { return count_ == SEGCAL_MAX_IMU_SAMPLES; }

  /// Microseconds after the segment's first keyframe; negative for the samples that lead to it.
  std::int32_t time(int i) const {
    std::int32_t t = anchor_us_[i / kStampsPerAnchor];
    for (int k = i - i % kStampsPerAnchor + 1; k <= i; ++k) t += delta_us_[k];
    return t;
  }

  InertialReading<S> reading(int i) const {
    InertialReading<S> r;
    for (int k = 0; k < 3; ++k) {
      r.gyro(k) = S(value_[i][k]) * gyro_step_;
      r.accel(k) = S(value_[i][3 + k]) * accel_step_;
    }
    return r;
  }

  /// Stamps must grow, by less than 65 ms. False if the sample does not fit.
  bool push(std::int32_t t_us, const InertialReading<S>& reading) {
    const std::int32_t delta = count_ > 0 ? t_us - newest_us_ : 0;
    if (full() || delta > 65535) return false;
    if (count_ % kStampsPerAnchor == 0) anchor_us_[count_ / kStampsPerAnchor] = t_us;
    delta_us_[count_] = static_cast<std::uint16_t>(delta);
    newest_us_ = t_us;
    for (int k = 0; k < 3; ++k) {
      value_[count_][k] = pack_value(reading.gyro(k), gyro_step_);
      value_[count_][3 + k] = pack_value(reading.accel(k), accel_step_);
    }
    ++count_;
    return true;
  }

 private:
  std::int32_t count_ = 0, newest_us_ = 0;
  S gyro_step_ = S(0), accel_step_ = S(0);
  std::int32_t anchor_us_[SEGCAL_MAX_IMU_SAMPLES / kStampsPerAnchor + 1];
  std::uint16_t delta_us_[SEGCAL_MAX_IMU_SAMPLES];
  std::int16_t value_[SEGCAL_MAX_IMU_SAMPLES][6];
};

}  // namespace SEGCAL_NS
