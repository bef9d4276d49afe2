// IMUs that are faster than the device has memory for: m samples become one, at their mean time.
//
// Of a motion that curves, a mean is not the value at its middle: with samples h apart, H = m h,
//   mean = f + (h^2 / 2) f'' sum_i (i - (m - 1)/2)^2 / m = f + H^2 / 24 (1 - 1/m^2) f'',
// and H^2 f'' is the second difference of the means before and after. That much is taken off, when the next mean is
// there: what comes out is one group late. Without it groups of 4, 6 and 8 of a hand-held device's 200 Hz give answers
// whose mean (error/sigma)^2 is 2, 6 and 13. The density of white noise is kept over more than a few samples: second
// differences sum to next to nothing.
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
  void clear() { count_ = means_ = 0; }
  /// Of groups: the time of the newest mean that stays when the newest one or two samples go; false if there is none.
  bool stays(int samples, std::int64_t* t_ns) const {
    const int i = in_ended_group(samples) ? 1 : 0;
    if (i < means_) *t_ns = mean_[i].t_ns;
    return i < means_;
  }
  /// Of groups: forgets the newest one or two samples and all that they are part of, the open group and the one that
  /// ended before. Returns how many of those that came out, 0 or 1, had them in it and must be taken back.
  int drop_newest(int samples) {
    const bool ended = means_ > 0 && in_ended_group(samples);
    count_ = 0;
    if (!ended) return 0;
    for (int i = 0; i + 1 < kMeans; ++i) mean_[i] = mean_[i + 1];
    return --means_ > 0 ? 1 : 0;
  }
  /// Takes a sample; true if `t_ns` and `reading` have become those
  /// of a whole group. With groups of one: those of the sample.
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
    end_group();
    if (means_ < 2) return false;
    *t_ns = mean_[1].t_ns;
    *reading = mean_[1].reading;
    if (means_ > 2 && evenly_spaced()) sharpen(reading);
    return true;
  }

 private:
  /// Newest first.
  static constexpr int kMeans = 3;
  struct Mean {
    std::int64_t t_ns;
    InertialReading<S> reading;
  };
  bool in_ended_group(int samples) const { return count_ < samples; }
  void end_group() {
    for (int i = kMeans - 1; i > 0; --i) mean_[i] = mean_[i - 1];
    if (means_ < kMeans) ++means_;
    const S share = S(1) / S(count_);
    mean_[0].t_ns = first_ns_ + after_first_ns_ / count_;
    mean_[0].reading.gyro = sum_.gyro * share;
    mean_[0].reading.accel = sum_.accel * share;
    count_ = 0;
  }
  /// No sample was left out between the newest three.
  bool evenly_spaced() const {
    const std::int64_t newer = mean_[0].t_ns - mean_[1].t_ns, older = mean_[1].t_ns - mean_[2].t_ns;
    return 4 * newer < 5 * older && 4 * older < 5 * newer;
  }
  void sharpen(InertialReading<S>* reading) const {
    const S share = (S(1) - S(1) / S(group_ * group_)) / S(24);
    const InertialReading<S>&after = mean_[0].reading, &here = mean_[1].reading, &before = mean_[2].reading;
    reading->gyro -= share * (after.gyro - S(2) * here.gyro + before.gyro);
    reading->accel -= share * (after.accel - S(2) * here.accel + before.accel);
  }

  std::int32_t group_ = 1, count_ = 0, means_ = 0;
  std::int64_t first_ns_ = 0, after_first_ns_ = 0;  ///< of the group; sum of the distances from its first stamp
  InertialReading<S> sum_;
  Mean mean_[kMeans];
};

}  // namespace SEGCAL_NS
