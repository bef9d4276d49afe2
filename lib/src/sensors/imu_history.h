// The last second or two of raw IMU samples: a ring buffer that the filter integrates over and segments are cut from.
#pragma once

#include <cstdint>

#include "sensors/imu_samples.h"

namespace SEGCAL_NS {

constexpr int kImuHistory = SEGCAL_IMU_HISTORY;

template <class S>
class ImuHistory {
 public:
  void clear() { count_ = head_ = 0; }
  int size() const { return count_; }

  /// Stamps must grow; the caller has checked that. The oldest sample is overwritten when full.
  void push(std::int64_t t_ns, const InertialReading<S>& reading) {
    t_[head_] = t_ns;
    reading_[head_] = reading;
    head_ = (head_ + 1) % kImuHistory;
    if (count_ < kImuHistory) ++count_;
  }

  /// Undoes the last `n` times of push(), or all since clear().
  void take_back(int n) {
    for (; n > 0 && count_ > 0; --n, --count_) head_ = (head_ == 0 ? kImuHistory : head_) - 1;
  }

  /// i = 0 is the oldest sample.
  std::int64_t time(int i) const { return t_[index(i)]; }
  const InertialReading<S>& reading(int i) const { return reading_[index(i)]; }
  std::int64_t newest() const { return count_ ? time(count_ - 1) : INT64_MIN; }
  std::int64_t oldest() const { return count_ ? time(0) : INT64_MAX; }

  /// True if samples on both sides of [t0, t1] are there, so that its ends can be interpolated.
  bool covers(std::int64_t t0, std::int64_t t1) const { return count_ > 1 && oldest() <= t0 && newest() >= t1; }

  /// Last sample with time <= t (which must be covered).
  int at_or_before(std::int64_t t) const { return SEGCAL_NS::at_or_before(*this, t); }

  /// degC above 25 of the newest samples: it changes slowly.
  void set_warmth(S warmth) { warmth_ = warmth; }
  S warmth() const { return warmth_; }

 private:
  int index(int i) const { return (head_ - count_ + i + kImuHistory) % kImuHistory; }
  int count_ = 0, head_ = 0;
  S warmth_ = S(0);
  std::int64_t t_[kImuHistory];
  InertialReading<S> reading_[kImuHistory];
};

/// What terms need to know about [t0, t1], too short a time for the warmth to change. `R_GI`: at t0.
template <class S>
Stretch<S> stretch_between(std::int64_t t0, std::int64_t t1, S warmth, const Mat3<S>& R_GI,
                           const ImuIntegrator<S>& integrator) {
  const std::int64_t zero = integrator.time_zero_ns();
  return {warmth, warmth, S(t0 - zero) * S(1e-9), S(t1 - zero) * S(1e-9), &R_GI, true};
}

/// Samples [first, last] of the history and the warmth of then, while newer ones come in and older ones go.
template <class S>
struct ImuStretch {
  const ImuHistory<S>& imu;
  std::int32_t first, count;
  S warmth;

  ImuStretch(const ImuHistory<S>& history, std::int32_t first_index, std::int64_t last_ns, S warmth_then)
      : imu(history), first(first_index), count(history.at_or_before(last_ns) + 1 - first_index), warmth(warmth_then) {}
  int size() const { return count; }
  std::int64_t time(int i) const { return imu.time(first + i); }
  const InertialReading<S>& reading(int i) const { return imu.reading(first + i); }
  int at_or_before(std::int64_t t) const { return SEGCAL_NS::at_or_before(*this, t); }

  /// Integrates from t0 to t1 > t0, which must be covered. `R_GI`: at t0.
  void integrate(std::int64_t t0, std::int64_t t1, const Mat3<S>& R_GI, ImuIntegrator<S>* integrator) const {
    integrate_samples<S>(*this, t0, t1, S(1e-9), integrator, stretch_between(t0, t1, warmth, R_GI, *integrator));
  }
};

}  // namespace SEGCAL_NS
