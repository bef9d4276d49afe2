// What a device says: reports are made by a job, out of sight, and published whole when it takes effect.
#pragma once

#include "api/release.h"
#include "calibration/course.h"
#include "information/metrics.h"

namespace SEGCAL_NS {

/// Directions and singular values of a finished analysis.
template <class S>
struct Directions {
  std::int32_t n = 0;
  S s[kMaxTheta];              ///< singular values against the prior, largest first
  S V[kMaxTheta * kMaxTheta];  ///< column i: direction i, in prior units

  void copy(const InformationAnalysis<S>& a) {
    n = a.n;
    for (int i = 0; i < n; ++i) s[i] = a.s[i];
    for (int i = 0; i < n * n; ++i) V[i] = a.V[i];
  }
  /// Direction i's sigma after the measurement, in units of the prior's.
  S relative_sigma(int i) const { return S(1) / square_root(S(1) + s[i] * s[i]); }
};

/// The segment that was scored last.
template <class S>
struct ScoreReport {
  SegmentSummary<S> segment;
  Directions<S> directions;
};

/// Image residuals over all segments that took part, px.
template <class S>
struct ReprojectionFigures {
  S rms = S(0);     ///< of the lengths, without the points left out as far off
  S median = S(0);  ///< of the lengths, with them
};

template <class S>
struct CalibrationReport {
  Release<S> release;
  Calibration<S> theta;  ///< where the fit ended; what is released has fixed parameters put back
  CalibrationFit<S> fit;
  std::int32_t segments = 0, partitions = 0;
  ReprojectionFigures<S> reprojection;
  Directions<S> directions;  ///< over all segments that took part
  std::conditional_t<(kHistory > 0), Course<S>, NoCourse> course;
};

}  // namespace SEGCAL_NS
