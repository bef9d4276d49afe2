// Where a segment ends, if its length is left open: lively stretches are not cut, quiet ones do not fill a segment.
//
// Lively is measured per keyframe, from the raw samples: mean square of the rotation
// rate, and of the specific force about its mean over the last seconds, each over its
// own mean so far. So there is nothing to set: 2 is what is usual for this device.
#pragma once

#include "sensors/imu_history.h"

namespace SEGCAL_NS {

template <class S>
class Liveliness {
 public:
  void reset() { *this = Liveliness(); }

  /// Takes the samples in (from, to].
  [[gnu::cold]] void add(const ImuHistory<S>& imu, std::int64_t from_ns, std::int64_t to_ns) {
    S turn = S(0), push = S(0);
    int n = 0;
    for (int i = imu.at_or_before(from_ns) + 1; i < imu.size() && imu.time(i) <= to_ns; ++i, ++n) {
      const InertialReading<S>& r = imu.reading(i);
      if (!began_) mean_force_ = r.accel;
      began_ = true;
      const S dt = S(imu.time(i) - imu.time(i - 1)) * S(1e-9);
      mean_force_ += (r.accel - mean_force_) * share(dt, kForceSeconds);
      turn += r.gyro.squaredNorm();
      push += (r.accel - mean_force_).squaredNorm();
    }
    if (n == 0) return;
    const S dt = S(to_ns - from_ns) * S(1e-9);
    seconds_ += dt;
    // The mean so far to begin with, later of the last minute.
    const S slow = seconds_ < kUsualSeconds ? dt / seconds_ : share(dt, kUsualSeconds);
    usual_turn_ += (turn / S(n) - usual_turn_) * slow;
    usual_push_ += (push / S(n) - usual_push_) * slow;
    const S tiny = S(1e-12);
    const S now = turn / S(n) / (usual_turn_ + tiny) + push / S(n) / (usual_push_ + tiny);
    now_ += (now - now_) * share(dt, kNowSeconds);
  }

  bool lively() const { return now_ > S(2); }
  bool quiet() const { return now_ < S(1); }

 private:
  static constexpr S kForceSeconds = S(2), kUsualSeconds = S(60), kNowSeconds = S(0.5);
  /// How much of a running mean over `span` a stretch of dt replaces.
  static S share(S dt, S span) { return dt / (dt + span); }

  Vec3<S> mean_force_ = Vec3<S>::Zero();
  S usual_turn_ = S(0), usual_push_ = S(0), now_ = S(2), seconds_ = S(0);
  bool began_ = false;
};

/// True if a segment of this length (s) may end: it is as long as segments
/// are, and nothing happens that is worth more; or nothing happens at all.
template <class S>
bool ends_here(const Liveliness<S>& liveliness, S length, S usual, S least, S most) {
  if (length >= most) return true;
  if (length < least) return false;
  return length >= usual ? !liveliness.lively() : liveliness.quiet();
}

}  // namespace SEGCAL_NS
