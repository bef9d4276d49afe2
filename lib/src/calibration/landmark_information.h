// What a segment's image points say about one of its landmarks, with everything else known.
#pragma once

#include "segments/elimination.h"

namespace SEGCAL_NS {

/// A tie's distance, and its horizontal distance from the other ties, are this many sigmas at least (squared).
template <class S>
constexpr S kKnownDistance2 = S(100);

/// The residual of an image point and its rows over its landmark; false where it is left out or behind the camera.
template <class S>
bool tells_of_landmark(const Segment<S>& segment, const Observation& z, const Calibration<S>& theta,
                       const MeasurementModel<S>& model, ReprojectionRows<S>* rows) {
  return !z.rejected && point_rows<S>(z, theta, exposure_of(segment, z, theta, model.g, false),
                                      segment.states.landmark[z.landmark], nullptr, rows);
}

/// fold_landmark() where tracks drift.
template <class S>
void fold_walking_landmark(const Segment<S>& segment, int j, const Calibration<S>& theta,
                           const MeasurementModel<S>& model, PackedTriangle<S>* R) {
  constexpr int kPoint = 2 * kLandmarkColumns;
  TrackNoise<S> track;
  S block[kPoint * kMaxKeyframes * kMaxCameras];
  track.begin();
  for (int o = segment.first_observation[j]; o < segment.first_observation[j + 1]; ++o) {
    const Observation& z = segment.observation[o];
    ReprojectionRows<S> rows;
    if (!tells_of_landmark(segment, z, theta, model, &rows)) continue;
    S* const point = block + kPoint * track.points();
    for (int i = 0; i < kPoint; ++i) point[i] = rows.J_l(i / kLandmarkColumns, i % kLandmarkColumns);
    track.add(z.camera, segment.t_us[z.keyframe], rows.r, model);
  }
  track.weigh(model);
  track.whiten(block, kLandmarkColumns, 0, kLandmarkColumns);
  fold_rows(*R, block, 2 * track.points(), kLandmarkColumns, 0, kLandmarkColumns);
}

/// Folds what a segment's image points say about landmark j,
/// with everything else known, into a triangle over its columns.
template <class S>
void fold_landmark(const Segment<S>& segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                   PackedTriangle<S>* R) {
  if constexpr (kTrackWalk) {
    if (TrackNoise<S>::walks(model)) {
      fold_walking_landmark(segment, j, theta, model, R);
      return;
    }
  }
  const S inverse_sigma = S(1) / model.pixel_sigma;
  S block[2 * kLandmarkColumns];
  for (int o = segment.first_observation[j]; o < segment.first_observation[j + 1]; ++o) {
    const Observation& z = segment.observation[o];
    ReprojectionRows<S> rows;
    if (!tells_of_landmark(segment, z, theta, model, &rows)) continue;
    const S scale =
        square_root(robust_term(model, rows.r.squaredNorm() * inverse_sigma * inverse_sigma).weight) * inverse_sigma;
    for (int i = 0; i < 2 * kLandmarkColumns; ++i)
      block[i] = scale * rows.J_l(i / kLandmarkColumns, i % kLandmarkColumns);
    fold_rows(*R, block, 2, kLandmarkColumns, 0, kLandmarkColumns);
  }
}

/// One over the variance of a landmark's distance in m, from one segment's image points; 0 if it is hardly known.
template <class S>
S distance_information(const Segment<S>& segment, int j, const Calibration<S>& theta,
                       const MeasurementModel<S>& model) {
  S data[packed_size(kLandmarkColumns)];
  PackedTriangle<S> R(data, kLandmarkColumns);
  R.clear();
  fold_landmark(segment, j, theta, model, &R);
  const S rho = segment.states.landmark[j].rho, relative = rho * R(2, 2);
  if (!(rho > S(0)) || relative * relative < kKnownDistance2<S>) return S(0);
  return relative * relative * rho * rho;
}

}  // namespace SEGCAL_NS
