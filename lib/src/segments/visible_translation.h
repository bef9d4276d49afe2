// Does a segment's translation show in its images at all?
//
// Rotation in place leaves the metric scale (p_CI against the landmarks' distances) open. The fit does not know the
// positions exactly, though: it lets them take up noise, and a Jacobian taken at noisy positions reports information
// about scale that is not there (errors in variables). It is bounded: one unit per position component that was fitted,
// three per keyframe. So where all of the translation's visible effect is not clearly above that, it is noise, and the
// landmarks' inverse distances must be linearised as if the device had only turned.
#pragma once

#include "segments/exposure.h"
#include "segments/track_noise.h"

namespace SEGCAL_NS {

/// Squared whitened shift of landmark j's image points between their keyframes' positions and the position where the
/// landmark was seen first.
template <class S>
S visible_shift(const Segment<S>& segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model) {
  const Landmark<S>& l = segment.states.landmark[j];
  const Vec3<S>& p_first = segment.states.x[segment.observation[segment.first_observation[j]].keyframe].p_GI;
  S total = S(0);
  TrackNoise<S> track;
  track.begin();
  for (int o = segment.first_observation[j]; o < segment.first_observation[j + 1]; ++o) {
    const Observation& z = segment.observation[o];
    const Exposure<S> x = exposure_of(segment, z, theta, model.g, false);
    Vec2<S> moved, turned;
    const bool seen = with_camera(z, theta, x.warmth, [&](const CameraCalibration<S>& camera) {
      return project(camera, homogeneous_in_camera(camera, x.R_GI, x.p_GI, l), &moved) &&
             project(camera, homogeneous_in_camera(camera, x.R_GI, p_first, l), &turned);
    });
    if (!seen) continue;
    if (TrackNoise<S>::walks(model)) {
      track.add(z.camera, segment.t_us[z.keyframe], moved - turned, model);
    } else {
      total += (moved - turned).squaredNorm();
    }
  }
  if constexpr (kTrackWalk) {
    if (TrackNoise<S>::walks(model)) {
      track.weigh_equally(model);
      return track.squared_length();
    }
  }
  return total / (model.pixel_sigma * model.pixel_sigma);
}

/// True if the translation is clearly more than what fitting the positions to noise can feign: ten times that much, so
/// that the information on scale is overstated by a tenth at most.
template <class S>
bool translation_shows(const Segment<S>& segment, const Calibration<S>& theta, const MeasurementModel<S>& model) {
  const S enough = S(10) * S(3 * segment.n_keyframes);
  S total = S(0);
  for (int j = 0; j < segment.n_landmarks && total <= enough; ++j) total += visible_shift(segment, j, theta, model);
  return total > enough;
}

}  // namespace SEGCAL_NS
