// Is a stamp the next one of its stream? A flipped bit in one stamp must not cost more than that sample, and a clock
// that was set anew must not cost the session.
#pragma once

#include <cstdint>

namespace SEGCAL_NS {

/// Stamps beyond this are refused (146 years either way, ns): differences of two that are not always fit into 64 bits.
constexpr std::int64_t kMostStamp = (std::int64_t(1) << 62) - 1;

enum class StampVerdict : std::int32_t {
  good,  ///< follows the stamp before
  back,  ///< repeats it or goes back: refused
  far,   ///< more than kFarStampNs away, either way: refused until the new time persists
  anew   ///< the new time has persisted: the stream begins again here
};

/// A step between two samples that no pause of a sensor's driver explains, ns. What is nearer and goes back is a block
/// that came twice: it catches up by itself.
constexpr std::int64_t kFarStampNs = 1000000000;

class StampGuard {
 public:
  void reset() {
    began_ = false;
    doubted_ = 0;
  }
  /// Judges the next stamp. One that is good or begins anew is the last one from then on.
  StampVerdict take(std::int64_t t_ns) {
    if (t_ns > kMostStamp || t_ns < -kMostStamp) return StampVerdict::far;
    const std::int64_t step = began_ ? t_ns - last_ns_ : 1;
    if (step > 0 && step <= kFarStampNs) return accept(t_ns, StampVerdict::good);
    if (step <= 0 && step >= -kFarStampNs) return StampVerdict::back;
    const std::int64_t from_doubtful = t_ns - doubtful_ns_;
    doubted_ = doubted_ > 0 && from_doubtful > 0 && from_doubtful <= kFarStampNs ? doubted_ + 1 : 1;
    doubtful_ns_ = t_ns;
    return doubted_ < kPersists ? StampVerdict::far : accept(t_ns, StampVerdict::anew);
  }

 private:
  /// So many in a row, each following the one before: no longer flipped bits. 40 ms at 200 Hz.
  static constexpr std::int32_t kPersists = 8;
  StampVerdict accept(std::int64_t t_ns, StampVerdict verdict) {
    last_ns_ = t_ns;
    began_ = true;
    doubted_ = 0;
    return verdict;
  }
  std::int64_t last_ns_ = 0, doubtful_ns_ = 0;
  std::int32_t doubted_ = 0;
  bool began_ = false;
};

}  // namespace SEGCAL_NS
