// Single readings that no motion explains: a bit that flipped on the bus, a shock to the sensor's die.
//
// A spike stands alone: it is far from where the two readings before it lead, and the one after it is not. Far is kFarBends times
// the root mean square of the second differences of readings. A motion that begins with a jump goes on, so that what follows it is
// far from there too. A reading that is far is held back until the next one tells: none is lost but spikes, and none waits but
// these.
#pragma once

#include "sensors/inertial_state.h"

namespace host {

template <class S>
using InertialReading = SEGCAL_NS::InertialReading<S>;
template <class S>
using Vec3 = SEGCAL_NS::Vec3<S>;

template <class S>
class SpikeGate {
 public:
  using Reading = InertialReading<S>;
  /// A stream begins. `gyro_noise`, `accel_noise`: sigma of a reading's white noise, rad/s and m/s^2: bends below it mean nothing.
  void begin(S gyro_noise, S accel_noise) {
    bends_[0].begin(gyro_noise);
    bends_[1].begin(accel_noise);
    readings_ = 0;
    holds_ = bridges_ = false;
  }
  /// Looks at the next reading: whether it is far from where the ones before lead. One that has told that the one before it was a spike is
  /// taken: it would be judged by the line that it confirmed.
  bool jumps(const Reading& r) {
    const Vec3<S>* const sensor[] = {&r.gyro, &r.accel};
    bool far = false;
    for (int i = 0; i < 2; ++i) far = bends_[i].look(*sensor[i]) || far;
    return far && !bridges_ && readings_ > kFewReadings;
  }
  /// Keeps the one that was looked at last, which jumps.
  void hold(std::int64_t t_ns, const Reading& reading) {
    held_ns_ = t_ns;
    held_ = reading;
    holds_ = true;
  }
  bool holds() const { return holds_; }
  std::int64_t held_ns() const { return held_ns_; }
  const Reading& held() const { return held_; }
  /// Whether the held reading stands alone, now that the next one is known, which has not been looked at.
  bool is_spike(const Reading& next) const {
    const Vec3<S>* const sensor[] = {&next.gyro, &next.accel};
    bool alone = false;
    for (int i = 0; i < 2; ++i) alone = bends_[i].was_alone(*sensor[i]) || alone;
    return alone;
  }
  /// The held one is a spike. It counts for what is far all the same: what comes often is no accident.
  void leave_out() {
    for (Bends& b : bends_) b.learn(readings_);
    holds_ = false;
    bridges_ = true;
  }
  /// The one that was looked at last is taken.
  void follow(const Reading& r) {
    const Vec3<S>* const sensor[] = {&r.gyro, &r.accel};
    for (int i = 0; i < 2; ++i) {
      bends_[i].learn(readings_);
      bends_[i].follow(*sensor[i], bridges_);
    }
    holds_ = bridges_ = false;
    if (readings_ < kMemory) ++readings_;
  }

 private:
  /// Of 164,000 real readings of each sensor at 200 Hz (six flights and walks, a phone) none that stands alone is further than 5.6
  /// times the root mean square; every second or fourth of them, without a filter: one in 16,000, at impacts (docs/results.md, "Spikes").
  static constexpr int kFarBends = 8;
  /// What follows a spike is nearer to where the readings before lead than half as far as the spike.
  static constexpr int kNearShare = 2;
  /// A spike is further off than so many steps of the line that it is measured from: a pulse that ends bends by its own steps.
  static constexpr int kSteeper = 2;
  /// A bend counts at most so many times the root mean square: what is being looked for does not raise the scale it is measured by.
  static constexpr int kMostBends = 4;
  static constexpr std::int32_t kMemory = 200;   ///< readings: a second, in which motion stays alike
  static constexpr std::int32_t kFewReadings = 20;

  /// Of one sensor: second differences of its readings, squared.
  class Bends {
   public:
    void begin(S noise) { mean_ = floor_ = S(3 * 6) * noise * noise; }   // three axes; a second difference has six variances
    bool look(const Vec3<S>& r) {
      bend_ = from_line(r, S(2), S(1));
      return bend_ > S(kFarBends * kFarBends) * mean_;
    }
    bool was_alone(const Vec3<S>& next) const {
      return bend_ > S(kFarBends * kFarBends) * mean_ && S(kNearShare * kNearShare) * from_line(next, S(3), S(2)) < bend_ &&
             S(kSteeper * kSteeper) * from_line(before_, S(1), S(0)) < bend_;
    }
    /// The `n`-th reading; beyond the memory's length, one more of so many.
    void learn(std::int32_t n) {
      const S most = S(kMostBends * kMostBends) * mean_;
      if (n > 1) mean_ += ((bend_ < most ? bend_ : most) - mean_) / S(n);
      if (mean_ < floor_) mean_ = floor_;
    }
    /// `bridges`: what the spike before it hid lies half way.
    void follow(const Vec3<S>& r, bool bridges) {
      for (int k = 0; k < 3; ++k) {
        before_(k) = bridges ? S(0.5) * (last_(k) + r(k)) : last_(k);
        last_(k) = r(k);
      }
    }

   private:
    /// Squared distance from a last - b before.
    S from_line(const Vec3<S>& r, S a, S b) const {
      S sum = S(0);
      for (int k = 0; k < 3; ++k) {
        const S d = r(k) - a * last_(k) + b * before_(k);
        sum += d * d;
      }
      return sum;
    }
    Vec3<S> before_ = Vec3<S>::Zero(), last_ = Vec3<S>::Zero();
    S bend_ = S(0), floor_ = S(0), mean_ = S(0);
  };

  Bends bends_[2];   ///< gyroscope, accelerometer
  Reading held_;
  std::int64_t held_ns_ = 0;
  std::int32_t readings_ = 0;
  bool holds_ = false, bridges_ = false;
};

}  // namespace host
