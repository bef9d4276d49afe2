// What a fit keeps of each segment from one pass over all of them to the next: its triangle, so that the way back needs
// no second elimination, and the integrals of its IMU links (segments/kept_links.h). Both are what would be made again,
// bit by bit: a build that has no memory for them (SEGCAL_KEEP_ELIMINATIONS 0) gives the same result, later.
//
// A triangle takes as much as its columns need. The memory is for all segments without effects and ties; beyond that
// those that find no room are eliminated a second time.
#pragma once

#include "segments/elimination.h"

namespace SEGCAL_NS {

template <class S, bool keeps>
class KeptEliminations {
 public:
  /// Of a fit: nothing is kept.
  void begin() {
    forget_triangles();
    for (auto& links : links_) links.forget();
  }
  /// They are at another theta or another damping than what comes now.
  void forget_triangles() {
    used_ = 0;
    for (std::int32_t& first : first_) first = -1;
  }
  /// Segment i, just eliminated without candidates.
  void keep(int i, SegmentEliminator<S>* eliminated) {
    const int n = eliminated->reduced().numbers_above_theta();
    if (used_ + n > kNumbers) return;
    copy_numbers(eliminated->reduced().numbers(), n, number_ + used_);
    first_[i] = used_;
    used_ += n;
  }
  /// Of segment i, as its elimination would give it, but for the rows of theta; null: not kept.
  const S* triangle(int i) const { return first_[i] < 0 ? nullptr : number_ + first_[i]; }
  KeptLinks<S, kMaxKeyframes>* links(int i) { return &links_[i]; }

 private:
  static constexpr int kRows = kPoseColumns * (kMaxKeyframes - 1) + 2 * kStateColumns;
  static constexpr int kNumbers =
      kMaxSegments * (packed_size(kRows + kMaxSensorColumns + 1) - packed_size(kMaxSensorColumns + 1));
  std::int32_t used_ = 0, first_[kMaxSegments];
  S number_[kNumbers];
  KeptLinks<S, kMaxKeyframes> links_[kMaxSegments];
};

/// Keeps nothing.
template <class S>
class KeptEliminations<S, false> {
 public:
  void begin() {}
  void forget_triangles() {}
  void keep(int, SegmentEliminator<S>*) {}
  const S* triangle(int) const { return nullptr; }
  KeptLinks<S, kMaxKeyframes>* links(int) { return nullptr; }
};

}  // namespace SEGCAL_NS
