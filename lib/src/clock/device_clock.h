// The search for the offset of two clocks as a device does it:
// samples and images in, slices of work, an answer at any time.
#pragma once

#include "api/stamp_guard.h"
#include "clock/gyro_nodes.h"
#include "clock/image_turns.h"
#include "clock/offset_sums.h"
#include "segcal/clock.h"

namespace SEGCAL_NS {

template <class S>
class DeviceClock {
 public:
  DeviceClock(const CameraCalibration<S>& camera, std::int32_t index, std::int64_t start_ns)
      : index_(index), start_ns_(start_ns) {
    images_.reset(camera);
    nodes_.reset();
    window_.clear();
  }

  /// Rates in rad/s, finite.
  int push_imu(std::int64_t t_ns, const Vec3<S>& w) {
    const StampVerdict verdict = imu_stamps_.take(t_ns);
    if (verdict == StampVerdict::back || verdict == StampVerdict::far) return SEGCAL_ERROR_STAMP;
    if (verdict == StampVerdict::anew) begin_anew();
    if (has_imu_) heard_ns_ += t_ns - imu_ns_;
    has_imu_ = true;
    imu_ns_ = t_ns;
    nodes_.add(t_ns, w);
    return SEGCAL_OK;
  }

  int push_tracks(std::int64_t t_ns, const segcal_point_t* points, std::int32_t n) {
    if (t_ns > kMostStamp || t_ns < -kMostStamp) return SEGCAL_ERROR_STAMP;
    const std::int64_t ahead = has_imu_ ? t_ns + start_ns_ - imu_ns_ : 0;
    if (ahead > kOtherClockNs || ahead < -kOtherClockNs) return left_out(SEGCAL_ERROR_STAMP);
    const StampVerdict verdict = image_stamps_.take(t_ns);
    if (verdict == StampVerdict::back || verdict == StampVerdict::far) return left_out(SEGCAL_ERROR_STAMP);
    if (!has_imu_ && has_image_ && t_ns > image_ns_) heard_ns_ += t_ns - image_ns_ < kFarStampNs ? t_ns - image_ns_ : 0;
    has_image_ = true;
    image_ns_ = t_ns;
    if (images_.too_soon(t_ns)) return SEGCAL_SKIPPED;
    if (images_.busy()) return left_out(SEGCAL_SKIPPED);  // the background has not come to the one before
    images_.begin(t_ns);
    for (std::int32_t i = 0; i < n; ++i) {
      if (points[i].camera != index_) continue;
      const auto inside = [](float x) { return x >= -1e6F && x <= 1e6F; };  // no for not-a-number
      if (inside(points[i].u) && inside(points[i].v)) images_.add(points[i].track_id, S(points[i].u), S(points[i].v));
    }
    return SEGCAL_WAITING;
  }

  bool has_work() const { return full_ || images_.busy() || (waiting_ > 0 && ready(queue_[first_]) != Ready::waits); }

  /// One slice.
  void step() {
    if (full_) return end_window();
    if (waiting_ > 0 && ready(queue_[first_]) != Ready::waits) return compare();
    TurnedPair<S> pair;
    if (images_.busy() && images_.step(&pair)) queue(pair);
  }

  void get(segcal_clock_result_t* out) const {
    const OffsetPeak<S> peak = sums_.peak();
    const S statistical = S(clock_criteria::kStep_s) * sums_.sigma(peak), common = S(clock_criteria::kCommon_s);
    const bool known = sums_.windows() > 0;
    out->sigma_s = static_cast<double>(square_root(statistical * statistical + common * common));
    out->status = status(peak, out->sigma_s);
    out->offset_s =
        1e-9 * static_cast<double>(start_ns_) + (known ? clock_criteria::kStep_s * static_cast<double>(peak.steps) : 0);
    out->correlation = known ? static_cast<double>(peak.correlation) : 0;
    out->correlation_at_start = known ? static_cast<double>(peak.at_start) : 0;
    out->correlation_elsewhere = known ? static_cast<double>(peak.elsewhere) : 0;
    out->pairs = sums_.pairs();
    out->windows = sums_.windows();
    out->windows_still = still_;
    out->images_left_out = images_left_out_;
    out->pairs_left_out = pairs_left_out_;
  }

 private:
  /// pairs wait for half a second of samples: 40 ms apart or more, and the samples may be late
  static constexpr int kQueue = 24;
  static constexpr std::int64_t kOtherClockNs = 2000000000;  ///< as segcal_push_tracks has it
  enum class Ready { waits, yes, never };
  using Place = NodePlace<S>;

  int left_out(int answer) {
    ++images_left_out_;
    return answer;
  }

  /// The IMU's clock is another one now: what waits was stamped with the old one.
  void begin_anew() {
    has_imu_ = false;
    nodes_.reset();
    images_.forget();
    image_stamps_.reset();
    first_ = waiting_ = 0;
  }

  void queue(const TurnedPair<S>& pair) {
    if (waiting_ == kQueue) drop_first();
    queue_[(first_ + waiting_++) % kQueue] = pair;
  }
  void drop_first() {
    take_first();
    ++pairs_left_out_;
  }
  void take_first() {
    first_ = (first_ + 1) % kQueue;
    --waiting_;
  }

  Ready ready(const TurnedPair<S>& pair) const {
    const std::int64_t reach = clock_criteria::kStepsEitherWay;
    const std::int64_t from = Place::of(pair.t1_ns + start_ns_).node - reach,
                       to = Place::of(pair.t2_ns + start_ns_).node + 1 + reach;
    if (nodes_.gone(from)) return Ready::never;
    return nodes_.covers(from, to) ? Ready::yes : Ready::waits;
  }

  /// The first pair that waits, at all offsets; or it only ends the window that it no longer belongs to.
  void compare() {
    const TurnedPair<S>& pair = queue_[first_];
    if (ready(pair) == Ready::never) return drop_first();
    const std::int64_t in_window = pair.t1_ns - window_ns_;
    if (window_.pairs > 0 &&
        (in_window < 0 || in_window >= static_cast<std::int64_t>(1e9 * clock_criteria::kWindow_s))) {
      full_ = true;
      return;
    }
    if (window_.pairs == 0) window_ns_ = pair.t1_ns;
    Place a = Place::of(pair.t1_ns + start_ns_), b = Place::of(pair.t2_ns + start_ns_);
    a.node -= clock_criteria::kStepsEitherWay;
    b.node -= clock_criteria::kStepsEitherWay;
    const S per_second = S(1) / (static_cast<S>(pair.t2_ns - pair.t1_ns) * S(1e-9));
    for (int i = 0; i < clock_criteria::kOffsets; ++i, ++a.node, ++b.node) {
      window_.add(i, pair.v, per_second * nodes_.turned(a, b));
    }
    window_.add_image(pair.v);
    take_first();
  }

  void end_window() {
    full_ = false;
    compared_ += window_.pairs;
    if (window_.pairs >= clock_criteria::kLeastPairsOfWindow) {
      window_.take_means_off();
      const S least = S(clock_criteria::kLeastTurning);
      if (window_.image_square < S(window_.pairs) * least * least) {
        ++still_;
      } else {
        sums_.add(&window_);
      }
    }
    window_.clear();
  }

  std::int32_t status(const OffsetPeak<S>& peak, double sigma_s) const {
    const bool patient = heard_ns_ >= static_cast<std::int64_t>(1e9 * clock_criteria::kPatience_s);
    if (compared_ < clock_criteria::kLeastPairs) return patient ? SEGCAL_CLOCK_FEW_IMAGES : SEGCAL_CLOCK_SEARCHING;
    if (sums_.windows() < clock_criteria::kLeastWindows || sums_.pairs() < clock_criteria::kLeastPairs) {
      return patient && still_ > sums_.windows() ? SEGCAL_CLOCK_STILL : SEGCAL_CLOCK_SEARCHING;
    }
    if (peak.correlation < S(clock_criteria::kLeastCorrelation) || !peak.inside()) return SEGCAL_CLOCK_NO_AGREEMENT;
    if (S(1) - peak.correlation > S(clock_criteria::kPeakStandsOut) * (S(1) - peak.elsewhere))
      return SEGCAL_CLOCK_REPEATS;
    return sigma_s <= clock_criteria::kMostSigma_s ? SEGCAL_CLOCK_FOUND : SEGCAL_CLOCK_SEARCHING;
  }

  std::int32_t index_;
  std::int64_t start_ns_, imu_ns_ = 0, image_ns_ = 0, window_ns_ = 0;
  std::int64_t heard_ns_ = 0;  ///< of the stream
  bool has_imu_ = false, has_image_ = false, full_ = false;
  int first_ = 0, waiting_ = 0;
  std::int32_t compared_ = 0, still_ = 0, images_left_out_ = 0, pairs_left_out_ = 0;
  StampGuard imu_stamps_, image_stamps_;
  TurnedPair<S> queue_[kQueue];
  GyroNodes<S> nodes_;
  ImageTurns<S> images_;
  WindowSums<S> window_;
  OffsetSums<S> sums_;
};

}  // namespace SEGCAL_NS
