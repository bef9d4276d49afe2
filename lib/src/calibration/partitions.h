// Partitions of a calibration: segments that share one gauge (paper, Sec. V-D, Alg. 2; docs/design.md, section 7).
//
// Neighbours in time are joined by the IMU samples between them. Segments of one map, whose states are in the same
// frame, are joined if they have enough tracks in common, the pair with the most first: a spanning forest, each edge of
// which that is not an IMU join costs a few ties. The gauge is held on the first segment of each partition only.
#pragma once

#include "calibration/ties.h"

namespace SEGCAL_NS {

constexpr int kSharedLandmarks = SEGCAL_SHARED_LANDMARKS;

/// A segment's place among its neighbours.
template <class S>
struct SegmentLink {
  Join join = Join::none;
  bool passes_on = false;  ///< the next segment hangs on this one
  S gap_s = S(0);
};

/// Where a segment ends.
struct SegmentEnd {
  std::int64_t t_ns = 0;
  std::uint32_t session = 0, serial = 0;
};

template <class S>
SegmentEnd end_of(const Segment<S>& s) {
  return {s.t0_ns + std::int64_t(s.t_us[s.n_keyframes - 1]) * 1000, s.session, s.serial};
}

/// How segment b hangs on the one before it that was kept or condensed, which ended at `a`.
template <class S>
SegmentLink<S> link_after(const SegmentEnd& a, const Segment<S>& b) {
  SegmentLink<S> link;
  if (a.session != b.session) return link;
  if (b.t0_ns <= a.t_ns) return link;  // the clock was set back in between: how long the biases walked is not known
  link.join = b.serial == a.serial + 1 && b.lead_us > 0 ? Join::imu : Join::bias;
  // What was restored may say anything: the difference of two stamps need not fit.
  const std::uint64_t gap_ns = static_cast<std::uint64_t>(b.t0_ns) - static_cast<std::uint64_t>(a.t_ns);
  link.gap_s = S(gap_ns < INT64_MAX ? static_cast<std::int64_t>(gap_ns) : INT64_MAX) * S(1e-9);
  return link;
}

/// Tracks that two segments of one session and one frame have in common.
template <class S>
int shared_tracks(const Segment<S>& a, const Segment<S>& b) {
  if (a.session != b.session || a.frame != b.frame || !a.has_origin_of(b)) return 0;
  int n = 0;
  for (int i = 0; i < a.n_landmarks; ++i) n += landmark_of_track(b, a.track_id[i]) >= 0 ? 1 : 0;
  return n;
}

template <class S>
class Partitions {
 public:
  /// Joins what can be joined, at the present states, and gives tied landmarks one value each. Image points that are
  /// marked as rejected tie nothing.
  [[gnu::cold]] void form(Segment<S>* const* segment, const SegmentLink<S>* link, int count,
                          const Calibration<S>& theta, const MeasurementModel<S>& model) {
    count_ = count;
    sets_.reset(count);
    ties_.clear();
    for (int i = 1; i < count; ++i) {
      if (link[i].join == Join::imu) sets_.join(i - 1, i);
    }
    if (kMaxTies < kFewestTies) return;
    for (int b = 1; b < count; ++b) {
      for (int a = 0; a < b; ++a)
        shared(a, b) = static_cast<std::uint16_t>(sets_.same(a, b) ? 0 : shared_tracks(*segment[a], *segment[b]));
    }
    for (int a, b; next_pair(&a, &b); shared(a, b) = 0) {
      if (ties_.connect(segment, a, b, theta, model, &sets_)) sets_.join(a, b);
    }
    ties_.spread(segment, count, &sets_);
  }

  int count() {
    int n = 0;
    for (int i = 0; i < count_; ++i) n += is_first(i) ? 1 : 0;
    return n;
  }
  /// The first segment of segment i's partition.
  int first_of(int i) { return sets_.root(i); }
  bool is_first(int i) { return sets_.root(i) == i; }
  const Ties<S>& ties() const { return ties_; }

 private:
  /// Place of the pair a < b.
  std::uint16_t& shared(int a, int b) { return shared_[b * (b - 1) / 2 + a]; }

  /// The pair with the most tracks in common whose segments are not in one set yet; the first of equals.
  bool next_pair(int* a, int* b) {
    int most = kSharedLandmarks - 1;
    for (int j = 1; j < count_; ++j) {
      for (int i = 0; i < j; ++i) {
        if (shared(i, j) <= most || sets_.same(i, j)) continue;
        most = shared(i, j);
        *a = i;
        *b = j;
      }
    }
    return most >= kSharedLandmarks;
  }

  std::int32_t count_ = 0;
  DisjointSets sets_;
  Ties<S> ties_;
  std::uint16_t shared_[kMaxSegments * (kMaxSegments - 1) / 2 + 1];
};

}  // namespace SEGCAL_NS
