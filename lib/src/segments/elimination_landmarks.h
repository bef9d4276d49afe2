// SegmentEliminator: landmarks, each alone, and then the ties, whose columns stay.
#pragma once

#include "segments/elimination.h"

namespace SEGCAL_NS {

template <class S>
bool SegmentEliminator<S>::fold_landmarks_step(const Segment<S>& segment, const Calibration<S>& theta,
                                               const MeasurementModel<S>& model, S damping) {
  const S landmark_damping = damping / kTypicalLandmarkStep<S>;
  SEGCAL_SLICES(inner_place_) {
    // Those that end first go first: the triangle fills up to the last keyframe seen so far, and no further.
    for (k_ = 0; k_ < segment.n_keyframes; ++k_) {
      for (j_ = 0; j_ < segment.n_landmarks; ++j_) {
        if (segment.last_keyframe(j_) != k_ || layout().tied.place_of(j_) >= 0) continue;
        fit_ = landmark_block().build(segment, j_, theta, model, layout(), camera_term_, landmark_damping);
        if (fit_.used < 2) continue;
        landmark_block().eliminate(&fit_);
        reduced_.begin_visual(landmark_block().rest(), fit_.rows - kLandmarkColumns, landmark_block().stride(),
                              fit_.first_keyframe, fit_.last_keyframe, false);
        SEGCAL_PAUSE(inner_place_);
        SEGCAL_AWAIT(inner_place_, reduced_.fold_step());
        counts_.image_points += fit_.used;
        ++counts_.landmarks;
        prior_share_ += fit_.prior_share;
        SEGCAL_PAUSE(inner_place_);
      }
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

/// After the other landmarks, whose rows need not go through the ties' columns then. A tie's prior and damping are not
/// the segment's: they count once for all (calibrator.h).
template <class S>
bool SegmentEliminator<S>::fold_ties_step(const Segment<S>& segment, const Calibration<S>& theta,
                                          const MeasurementModel<S>& model) {
  SEGCAL_SLICES(inner_place_) {
    for (j_ = 0; j_ < layout().tied.n; ++j_) {
      fit_ = landmark_block().build_tied(segment, j_, theta, model, layout(), camera_term_);
      if (fit_.used == 0) continue;
      reduced_.begin_visual(landmark_block().tied_rows(), fit_.rows, landmark_block().stride(), fit_.first_keyframe,
                            fit_.last_keyframe, true);
      SEGCAL_PAUSE(inner_place_);
      SEGCAL_AWAIT(inner_place_, reduced_.fold_step());
      counts_.image_points += fit_.used;
      SEGCAL_PAUSE(inner_place_);
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

}  // namespace SEGCAL_NS
