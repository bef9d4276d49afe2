// Landmarks from tracks and known poses: a linear start and a few damped Gauss-Newton steps, with the prior on the
// inverse distance that keeps a track without parallax a direction.
#pragma once

#include "segments/segment.h"
#include "segments/weights.h"

namespace SEGCAL_NS {

/// First guess: the ray of the first image point, and the inverse distance that brings the others' rays together in the
/// least-squares sense: u x (A m + rho b) = 0 for each of them.
template <class S>
bool start_landmark(const Segment<S>& segment, int j, const Calibration<S>& theta, Landmark<S>* l) {
  const Observation& first = segment.observation[segment.first_observation[j]];
  const CameraCalibration<S>& c0 = theta.camera[first.camera];
  const State<S>& x0 = segment.states.x[first.keyframe];
  Vec2<S> xy;
  if (!unproject(c0, Vec2<S>(S(first.u), S(first.v)), &xy)) return false;
  const Vec3<S> ray = c0.R_CI.transpose() * Vec3<S>(xy.x(), xy.y(), S(1));
  l->m = x0.R_GI * (ray / square_root(ray.squaredNorm()));
  l->o = x0.p_GI - x0.R_GI * (c0.R_CI.transpose() * c0.p_CI);
  S numerator = S(0), denominator = S(0);
  for (int o = segment.first_observation[j] + 1; o < segment.first_observation[j + 1]; ++o) {
    const Observation& z = segment.observation[o];
    const CameraCalibration<S>& c = theta.camera[z.camera];
    const State<S>& x = segment.states.x[z.keyframe];
    if (!unproject(c, Vec2<S>(S(z.u), S(z.v)), &xy)) continue;
    const Vec3<S> u(xy.x(), xy.y(), S(1));
    const Vec3<S> a = cross<S>(u, c.R_CI * (x.R_GI.transpose() * l->m));
    const Vec3<S> b = cross<S>(u, c.R_CI * (x.R_GI.transpose() * (l->o - x.p_GI)) + c.p_CI);
    numerator -= a.dot(b);
    denominator += b.squaredNorm();
  }
  l->rho = denominator > S(1e-8) ? numerator / denominator : S(0);
  if (!(l->rho > S(0))) l->rho = S(0);
  if (l->rho > S(5)) l->rho = S(5);
  return true;
}

/// Robust cost of landmark l and, optionally, its normal equations' triangle [3 | rhs] by QR.
template <class S>
S landmark_cost(const Segment<S>& segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                const Landmark<S>& l, S* triangle) {
  const S inverse_sigma = S(1) / model.pixel_sigma;
  const S prior = l.rho / model.inverse_depth_sigma;
  S cost = prior * prior;
  PackedTriangle<S> R(triangle, 4);
  S block[2 * 4], work[4];
  if (triangle) {
    R.clear();
    S row[4] = {S(0), S(0), S(1) / model.inverse_depth_sigma, -prior};
    fold_rows(R, row, 1, 4, 2, 4, work);
  }
  for (int o = segment.first_observation[j]; o < segment.first_observation[j + 1]; ++o) {
    const Observation& z = segment.observation[o];
    if (z.rejected) continue;
    const State<S>& x = segment.states.x[z.keyframe];
    ReprojectionRows<S> rows;
    const Vec2<S> uv(S(z.u), S(z.v));
    const bool seen = triangle ? reprojection_rows(theta.camera[z.camera], x.R_GI, x.p_GI, x.R_GI, x.p_GI, l, uv, &rows)
                               : reprojection_residual(theta.camera[z.camera], x.R_GI, x.p_GI, l, uv, &rows.r);
    const RobustTerm<S> robust = robust_term(model, seen ? rows.r.squaredNorm() * inverse_sigma * inverse_sigma : S(1e4));
    cost += robust.cost;
    if (!seen || !triangle) continue;
    const S scale = square_root(robust.weight) * inverse_sigma;
    for (int i = 0; i < 2; ++i) {
      for (int c = 0; c < 3; ++c) block[4 * i + c] = scale * rows.J_l(i, c);
      block[4 * i + 3] = -scale * rows.r(i);
    }
    fold_rows(R, block, 2, 4, 0, 4, work);
  }
  return cost;
}

/// Damped Gauss-Newton from *l, at most `steps` of them; returns the robust cost reached.
template <class S>
S refine_landmark(const Segment<S>& segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                  int steps, Landmark<S>* l) {
  S triangle[packed_size(4)];
  S cost = landmark_cost<S>(segment, j, theta, model, *l, triangle);
  for (int i = 0; i < steps; ++i) {
    S step[3];
    const PackedTriangle<S> R(triangle, 4);
    for (int c = 0; c < 3; ++c) step[c] = R(c, 3);
    back_substitute(R, 3, step);
    Landmark<S> trial;
    S trial_cost = cost;
    for (int half = 0; half < 5; ++half) {
      trial = *l;
      add_step(&trial, step);
      trial_cost = landmark_cost<S>(segment, j, theta, model, trial, nullptr);
      if (trial_cost < cost) break;
      for (S& s : step) s *= S(0.3);
    }
    if (!(trial_cost < cost)) break;
    const bool settled = cost - trial_cost < S(1e-3) * cost;
    *l = trial;
    if (settled || i + 1 == steps) return trial_cost;
    cost = landmark_cost<S>(segment, j, theta, model, *l, triangle);
  }
  return cost;
}

/// Triangulates landmark j of a segment at its keyframe states. False if no consistent point or direction is found:
/// the mean squared whitened residual stays above `limit`.
template <class S>
bool triangulate(Segment<S>* segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model, S limit) {
  Landmark<S> l;
  if (!start_landmark(*segment, j, theta, &l)) return false;
  const S cost = refine_landmark(*segment, j, theta, model, 8, &l);
  segment->states.landmark[j] = l;
  const int points = segment->first_observation[j + 1] - segment->first_observation[j];
  return is_finite(cost) && cost < limit * S(2 * points);
}

}  // namespace SEGCAL_NS
