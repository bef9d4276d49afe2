// Raw IMU samples of one segment, 20 bytes each: three 21-bit integers per sensor and a stamp in microseconds.
//
// Steps of 4e-5 rad/s and 2e-4 m/s^2 are a sixtieth of a good MEMS sensor's noise per sample, so storing costs nothing;
// the range is 41 rad/s (2400 deg/s) and 209 m/s^2 (21 g). Larger values are clipped here and counted as faults before.
#pragma once

#include <cstdint>

#include "sensors/imu_samples.h"

namespace SEGCAL_NS {

constexpr double kGyroStep = 4e-5;   ///< rad/s
constexpr double kAccelStep = 2e-4;  ///< m/s^2
constexpr std::int32_t kPackedLimit = (1 << 20) - 1;

template <class S>
std::uint64_t pack_vector(const Vec3<S>& v, double step) {
  std::uint64_t word = 0;
  for (int i = 0; i < 3; ++i) {
    const S scaled = v(i) / S(step);
    std::int32_t n = kPackedLimit;
    if (scaled < S(kPackedLimit)) {
      n = scaled < S(-kPackedLimit) ? -kPackedLimit : static_cast<std::int32_t>(scaled + (scaled < S(0) ? S(-0.5) : S(0.5)));
    }
    word |= static_cast<std::uint64_t>(static_cast<std::uint32_t>(n) & 0x1FFFFFu) << (21 * i);
  }
  return word;
}

template <class S>
Vec3<S> unpack_vector(std::uint64_t word, double step) {
  Vec3<S> v;
  for (int i = 0; i < 3; ++i) {
    // Shift left and back to carry the sign of the 21-bit number.
    const std::int32_t n = static_cast<std::int32_t>(static_cast<std::uint32_t>(word >> (21 * i)) << 11) / 2048;
    v(i) = S(n) * S(step);
  }
  return v;
}

template <class S>
class ImuStore {
 public:
  void clear() { count_ = 0; }
  int size() const { return count_; }
  bool full() const { return count_ == SEGCAL_MAX_IMU_SAMPLES; }
  std::int32_t time(int i) const { return t_us_[i]; }
  InertialReading<S> reading(int i) const {
    return {unpack_vector<S>(gyro_[i], kGyroStep), unpack_vector<S>(accel_[i], kAccelStep)};
  }
  /// t_us: microseconds after the segment's first keyframe (negative for the samples that lead to it).
  void push(std::int32_t t_us, const InertialReading<S>& reading) {
    if (full()) return;
    t_us_[count_] = t_us;
    gyro_[count_] = pack_vector(reading.gyro, kGyroStep);
    accel_[count_] = pack_vector(reading.accel, kAccelStep);
    ++count_;
  }

 private:
  std::int32_t count_ = 0;
  std::int32_t t_us_[SEGCAL_MAX_IMU_SAMPLES];
  std::uint64_t gyro_[SEGCAL_MAX_IMU_SAMPLES], accel_[SEGCAL_MAX_IMU_SAMPLES];
};

}  // namespace SEGCAL_NS
