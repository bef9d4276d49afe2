// IMUs that are faster than the device has memory for: m samples become one, their mean at their mean time.
//
// The integral of rate and force over a group is kept: the mean of m samples times m periods is their sum times a period. The
// density of white noise is kept as well: its variance falls by m as the period grows by m. What is lost is motion faster
// than the groups.
#pragma once

#include "sensors/inertial_state.h"

namespace SEGCAL_NS {

template <class S>
class Decimation {
 public:
  /// `group`: samples that become one, at least 1.
  void begin(std::int32_t group) {
    group_ = group;
    clear();
  }
  void clear() { count_ = 0; }
  /// True if there was an open one.
  bool drop_group() {
    const bool open = count_ > 0;
    clear();
    return open;
  }
  /// Takes a sample; true if `t_ns` and `reading` have become the mean of a whole group. With groups of one: those of the sample.
  bool take(std::int64_t* t_ns, InertialReading<S>* reading) {
    if (group_ == 1) return true;
    if (count_ == 0) {
      first_ns_ = *t_ns;
      after_first_ns_ = 0;
      sum_.gyro.setZero();
      sum_.accel.setZero();
    }
    after_first_ns_ += *t_ns - first_ns_;
    sum_.gyro += reading->gyro;
    sum_.accel += reading->accel;
    if (++count_ < group_) return false;
    const S share = S(1) / S(count_);
    *t_ns = first_ns_ + after_first_ns_ / count_;
    reading->gyro = sum_.gyro * share;
    reading->accel = sum_.accel * share;
    count_ = 0;
    return true;
  }

 private:
  std::int32_t group_ = 1, count_ = 0;
  std::int64_t first_ns_ = 0, after_first_ns_ = 0;  ///< of the group; sum of the distances from its first stamp
  InertialReading<S> sum_;
};

}  // namespace SEGCAL_NS
