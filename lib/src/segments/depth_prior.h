// The weak prior on a landmark's distance: that from the camera which saw it first, where that camera is now.
//
// A landmark is l = o + m / rho with o fixed, and a fit moves the cameras: counted from o, a landmark may look far
// although it is a millimetre before the camera, and a prior on rho says where the map is. Its image has h = R_CG (m +
// rho (o - c)), rho times the way from the camera c, so that the inverse distance from the camera is rho / |h|, regular
// at rho = 0.
#pragma once

#include "segments/exposure.h"
#include "segments/weights.h"

namespace SEGCAL_NS {

/// What the prior says of landmark j: its whitened residual, and the row over landmark, pose of the keyframe and
/// extrinsics.
template <class S>
struct DepthPrior {
  int keyframe, camera;
  S r;
  LandmarkRow<S> row;
};

/// Inverse distance over its sigma; h: of the landmark, in the camera. Behind the camera it is negative.
template <class S>
S depth_prior_residual(const Landmark<S>& l, const Vec3<S>& h, bool wide, const MeasurementModel<S>& model) {
  return l.rho / (square_root(h.squaredNorm()) * model.depth_sigma(l.rho, wide));
}

/// Cost of the prior on l as landmark j; not for ties.
template <class S>
S depth_prior_cost(const Segment<S>& segment, int j, const Landmark<S>& l, const Calibration<S>& theta,
                   const MeasurementModel<S>& model) {
  const Observation& z = segment.observation[segment.first_observation[j]];
  const State<S>& x = segment.states.x[z.keyframe];
  const Vec3<S> h = homogeneous_in_camera(theta.camera[z.camera], x.R_GI, x.p_GI, l);
  const S r = depth_prior_residual(l, h, segment.wide_depth_prior, model);
  return r * r;
}

template <class S>
DepthPrior<S> depth_prior(const Segment<S>& segment, int j, const Landmark<S>& l, const Calibration<S>& theta,
                          const MeasurementModel<S>& model) {
  const Observation& z = segment.observation[segment.first_observation[j]];
  const State<S>& x = segment.states.x[z.keyframe];
  DepthPrior<S> out;
  out.keyframe = z.keyframe;
  out.camera = z.camera;
  const LandmarkInCamera<S> at(theta.camera[z.camera], x.R_GI, x.p_GI, l);
  out.r = depth_prior_residual(l, at.h, segment.wide_depth_prior, model);
  // d (rho / |h|) = d rho / |h| - rho h' dh / |h|^3
  out.row = at.row_by(Vec3<S>(-out.r / at.h.squaredNorm() * at.h));
  out.row.l(2) += S(1) / (square_root(at.h.squaredNorm()) * model.depth_sigma(l.rho, segment.wide_depth_prior));
  return out;
}

}  // namespace SEGCAL_NS
