// Readings that no motion explains, one or two in a row: a bit that flipped on the bus, a shock to the sensor's die.
// One of them moves an answer by up to eight sigmas and hardly shows in its chi2 (docs/results.md).
//
// A spike stands alone: it is far from where the two readings before it lead, and what follows it is not. Far is
// kFarBends times the root mean square of the second differences of readings. A motion that begins with a jump goes on,
// so that what follows it is far from there too; a pulse that ends bends by its own steps.
#pragma once

#include "sensors/inertial_state.h"

namespace SEGCAL_NS {

template <class S>
class SpikeWatch {
 public:
  /// Of 164,000 real readings of each sensor at 200 Hz none, and no two in a row, stand alone further off
  /// (docs/results.md, "Spikes").
  static constexpr S kFarBends = S(8);
  /// What follows is nearer than this share of the spike's distance to where the readings before lead; half of it after
  /// two: a pulse of more readings fades.
  static constexpr S kNearShare = S(0.5);
  /// The distance is more than so many steps of the line that it is measured from.
  static constexpr S kSteeper = S(2);
  /// A bend counts in the mean for so many roots of it at most: what is being looked for does not raise its own scale.
  static constexpr S kMostBends = S(4);
  static constexpr std::int32_t kMemory = 200;      ///< readings: a second, in which motion stays alike
  static constexpr std::int32_t kFewReadings = 20;  ///< fewer judge nothing
  static constexpr S kLeastRate = S(100),
                     kLeastRateOfTwo = S(150);  ///< Hz; of a slower IMU one reading, or two, may be a twitch

  /// `noise`: densities; `rate_hz`: of the readings.
  void begin(const ImuNoise<S>& noise, S rate_hz) {
    widest_ = rate_hz < kLeastRate ? 0 : rate_hz < kLeastRateOfTwo ? 1 : 2;
    gyro_.floor = floor_of(noise.gyro, rate_hz);
    accel_.floor = floor_of(noise.accel, rate_hz);
    clear();
  }
  /// After a gap.
  void clear() { n_ = -1; }

  /// Takes the next reading; how many before it are a spike, which are then forgotten: 0 to 2.
  int after(const InertialReading<S>& next) {
    if (widest_ == 0) return 0;
    const int gyro = gyro_.judge(next.gyro, n_, widest_), accel = accel_.judge(next.accel, n_, widest_);
    const int wrong = n_ <= kFewReadings ? 0 : gyro > accel ? gyro : accel;
    gyro_.follow(next.gyro, wrong);
    accel_.follow(next.accel, wrong);
    if (wrong == 0 && n_ < kMemory) ++n_;
    return wrong;
  }

 private:
  /// One sensor.
  struct Line {
    S r[4][3] = {};               ///< the last readings; the newest is judged when the next one comes
    S mean = S(0), floor = S(0);  ///< of squared second differences
    S bend_before = S(0);         ///< of the last but one reading, squared

    /// How many of the newest stand alone. They count in the mean as well: what comes often is no accident. `n`:
    /// readings before the newest; less than two give no line, and the mean begins with the third.
    [[gnu::noinline]] int judge(const Vec3<S>& next, std::int32_t n, int widest) {
      S here = S(0);
      for (int i = 0; i < 3; ++i) {
        const S bend = r[3][i] - r[2][i] - (r[2][i] - r[1][i]);
        here += bend * bend;
      }
      const int wrong = stand_alone(next, 1, here) ? 1 : widest > 1 && stand_alone(next, 2, bend_before) ? 2 : 0;
      bend_before = here;
      if (n < 2) {
        mean = floor;
        return 0;
      }
      const S most = kMostBends * kMostBends * mean;
      mean += ((here < most ? here : most) - mean) / S(n);
      if (mean < floor) mean = floor;
      return wrong;
    }
    /// The `width` newest readings; `here`: squared distance of the first of them from where the two before it lead.
    [[gnu::noinline]] bool stand_alone(const Vec3<S>& next, int width, S here) const {
      if (!(here > kFarBends * kFarBends * mean)) return false;
      S there = S(0), slope = S(0);
      for (int i = 0; i < 3; ++i) {
        const S last = r[3 - width][i], step = last - r[2 - width][i], after = next(i) - last - S(width + 1) * step;
        there += after * after;
        slope += step * step;
      }
      return S(width * width) * there < kNearShare * kNearShare * here && kSteeper * kSteeper * slope < here;
    }
    /// `wrong`: as many as the sensor that found more.
    [[gnu::noinline]] void follow(const Vec3<S>& next, int wrong) {
      if (wrong > 0) bend_before = S(0);
      for (int i = 0; i < 3; ++i) {
        if (wrong == 0) {
          r[0][i] = r[1][i];
          r[1][i] = r[2][i];
          r[2][i] = r[3][i];
        } else if (wrong == 2) {
          r[2][i] = r[1][i];
          r[1][i] = r[0][i];
        }
        r[3][i] = next(i);
      }
    }
  };

  /// Three axes; a second difference has the variance of six readings.
  static S floor_of(S density, S rate_hz) { return S(3 * 6) * density * density * rate_hz; }

  Line gyro_, accel_;
  std::int32_t n_ = -1;      ///< readings so far, the newest not among them; -1: none
  std::int32_t widest_ = 0;  ///< readings that a spike may have; 0: none is looked for
};

}  // namespace SEGCAL_NS
