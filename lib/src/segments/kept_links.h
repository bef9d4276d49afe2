// Integrals of a segment's IMU links, kept while a fit is under way: the cost of a step, the next linearisation and its
// way back ask for the same ones, and an integral costs a hundred times what it takes to copy it.
//
// What is asked for decides whether a kept one is right, bit by bit: biases and theta's IMU part. The noise and the
// samples stay as they are for as long as the memory is not told to forget.
#pragma once

#include "sensors/imu_integral.h"

namespace SEGCAL_NS {

constexpr bool kKeepsEliminations = SEGCAL_KEEP_ELIMINATIONS != 0;

template <class S>
bool same_numbers(const ImuCalibration<S>& a, const ImuCalibration<S>& b) {
  return a.gyro_scale == b.gyro_scale && a.gyro_misalignment == b.gyro_misalignment && a.accel_scale == b.accel_scale &&
         a.accel_misalignment == b.accel_misalignment && a.R_AI == b.R_AI;
}

template <class S, int kLinks>
class KeptLinks {
 public:
  void forget() {
    for (Link& l : link_) l.known = false;
  }
  /// Of link k; null: not kept.
  const ImuIntegral<S>* find(int k, const ImuCalibration<S>& imu, const Vec3<S>& b_a, const Vec3<S>& b_g) const {
    const Link& l = link_[k];
    return l.known && l.b_a == b_a && l.b_g == b_g && same_numbers(imu_, imu) ? &l.integral : nullptr;
  }
  void keep(int k, const ImuCalibration<S>& imu, const Vec3<S>& b_a, const Vec3<S>& b_g, const ImuIntegral<S>& I) {
    if (!same_numbers(imu_, imu)) forget();
    imu_ = imu;
    link_[k].known = true;
    link_[k].b_a = b_a;
    link_[k].b_g = b_g;
    link_[k].integral = I;
  }

 private:
  struct Link {
    bool known;
    Vec3<S> b_a, b_g;
    ImuIntegral<S> integral;
  };
  ImuCalibration<S> imu_;
  Link link_[kLinks];
};

}  // namespace SEGCAL_NS
