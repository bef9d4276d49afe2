// What a fit keeps of each segment while it is under way; while none is, the open segment stands here during a score.
#pragma once

#include "calibration/chain.h"
#include "math/one_of.h"

namespace SEGCAL_NS {

template <class S>
class FitMemory {
 public:
  /// Of a fit: nothing is kept yet.
  void begin() { memory_.template begin<Kept>(); }
  /// Rows that came to segment i from its left, until its guest's step is known; null for the first.
  LeftRows<S>* left(int i) { return i > 0 ? &kept().other[i - 1].left : nullptr; }
  /// Then its states, before its own step moves them.
  void save(int i, const SegmentStates<S>& states) { new (&saved(i)) SegmentStates<S>(states); }
  SegmentStates<S>& saved(int i) { return i > 0 ? kept().other[i - 1].states : kept().first; }

  /// A segment to be built here; the next fit ends it.
  Segment<S>& begin_spare_segment() { return memory_.template begin<Segment<S>>(); }

 private:
  union LeftOrStates {
    LeftOrStates() {}
    LeftRows<S> left;
    SegmentStates<S> states;
  };
  struct Kept {
    SegmentStates<S> first;  ///< nobody is on its left
    LeftOrStates other[kMaxSegments > 1 ? kMaxSegments - 1 : 1];
  };
  Kept& kept() { return memory_.template get<Kept>(); }

  OneOf<Kept, Segment<S>> memory_;
};

}  // namespace SEGCAL_NS
