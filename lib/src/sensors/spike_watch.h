// Single readings that no motion explains: a bit that flipped on the bus, a shock to the sensor's die. One of them moves an answer by up to
// eight sigmas and hardly shows in its chi2 (docs/results.md).
//
// A spike stands alone: it is far from where the two readings before it lead, and the one after it is not. Far is kFarBends times the root
// mean square of the second differences of readings. A motion that begins with a jump goes on, so that what follows it is far from there
// too; a pulse that ends bends by its own steps.
#pragma once

#include "sensors/inertial_state.h"

namespace SEGCAL_NS {

template <class S>
class SpikeWatch {
 public:
  /// Of 164,000 real readings of each sensor at 200 Hz one that stands alone is further off (docs/results.md, "Spikes").
  static constexpr S kFarBends = S(8);
  /// The next reading is nearer than this share of the spike's distance to where the readings before lead.
  static constexpr S kNearShare = S(0.5);
  /// The distance is more than so many steps of the line that it is measured from.
  static constexpr S kSteeper = S(2);
  /// A bend counts in the mean for so many roots of it at most: what is being looked for does not raise its own scale.
  static constexpr S kMostBends = S(4);
  static constexpr std::int32_t kMemory = 200;      ///< readings: a second, in which motion stays alike
  static constexpr std::int32_t kFewReadings = 20;  ///< fewer judge nothing
  static constexpr S kLeastRate = S(100);           ///< Hz; of a slower IMU one period may be a twitch of 30 ms

  /// `noise`: densities; `rate_hz`: of the readings.
  void begin(const ImuNoise<S>& noise, S rate_hz) {
    is_on_ = rate_hz >= kLeastRate;
    gyro_.floor = floor_of(noise.gyro, rate_hz);
    accel_.floor = floor_of(noise.accel, rate_hz);
    clear();
  }
  /// After a gap.
  void clear() { n_ = -1; }

  /// Takes the next reading; true if the one before it is a spike, which is then forgotten.
  bool after(const InertialReading<S>& next) {
    if (!is_on_) return false;
    const bool gyro = gyro_.judge(next.gyro, n_), accel = accel_.judge(next.accel, n_);
    const bool spike = n_ > kFewReadings && (gyro || accel);
    gyro_.follow(next.gyro, spike);
    accel_.follow(next.accel, spike);
    if (!spike && n_ < kMemory) ++n_;
    return spike;
  }

 private:
  /// One sensor.
  struct Line {
    S before[3] = {}, last[3] = {}, newest[3] = {};   ///< the newest is judged when the next one comes
    S mean = S(0), floor = S(0);                      ///< of squared second differences

    /// True if the newest reading stands alone. It counts in the mean as well: what comes often is no accident. `n`: readings before it;
    /// less than two give no line, and the mean begins with the third.
    [[gnu::noinline]] bool judge(const Vec3<S>& next, std::int32_t n) {
      S here = S(0), there = S(0), slope = S(0);
      for (int i = 0; i < 3; ++i) {
        const S step = last[i] - before[i], bend = newest[i] - last[i] - step, after = next(i) - last[i] - S(2) * step;
        here += bend * bend;
        there += after * after;
        slope += step * step;
      }
      const bool alone = here > kFarBends * kFarBends * mean && there < kNearShare * kNearShare * here && kSteeper * kSteeper * slope < here;
      if (n < 2) {
        mean = floor;
      } else {
        const S most = kMostBends * kMostBends * mean;
        mean += ((here < most ? here : most) - mean) / S(n);
        if (mean < floor) mean = floor;
      }
      return alone;
    }
    [[gnu::noinline]] void follow(const Vec3<S>& next, bool spike) {
      for (int i = 0; i < 3; ++i) {
        if (!spike) {
          before[i] = last[i];
          last[i] = newest[i];
        }
        newest[i] = next(i);
      }
    }
  };

  /// Three axes; a second difference has the variance of six readings.
  static S floor_of(S density, S rate_hz) { return S(3 * 6) * density * density * rate_hz; }

  Line gyro_, accel_;
  std::int32_t n_ = -1;   ///< readings so far, the newest not among them; -1: none
  bool is_on_ = false;
};

}  // namespace SEGCAL_NS
