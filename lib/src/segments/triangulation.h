// Landmarks from tracks and known poses: a linear start and a few damped Gauss-Newton steps, with the prior on the
// inverse distance that keeps a track without parallax a direction.
#pragma once

#include "math/small_solvers.h"
#include "segments/depth_prior.h"
#include "segments/landmark_guess.h"
#include "segments/track_noise.h"

namespace SEGCAL_NS {

/// First guess of landmark j, from the rays of its image points.
template <class S>
bool start_landmark(const Segment<S>& segment, int j, const Calibration<S>& theta, const Vec3<S>& g, Landmark<S>* l) {
  const auto ray = [&](int o, Vec3<S>* from, Vec3<S>* m) {
    const Observation& z = segment.observation[o];
    const Exposure<S> x = exposure_of(segment, z, theta, g, false);
    return with_camera(z, theta, x.warmth, [&](const CameraCalibration<S>& camera) {
      return ray_in_world(camera, x.R_GI, x.p_GI, Vec2<S>(S(z.u), S(z.v)), from, m);
    });
  };
  if (!ray(segment.first_observation[j], &l->o, &l->m)) return false;
  LandmarkGuess<S> guess(l);
  for (int o = segment.first_observation[j] + 1; o < segment.first_observation[j + 1]; ++o) {
    Vec3<S> from, m;
    if (ray(o, &from, &m)) guess.add(from, m);
  }
  guess.finish();
  return true;
}

/// Rows [3 | rhs] on their way into a triangle: folded many at a time, since a reflection has a fixed price.
template <class S>
class LandmarkRows {
 public:
  explicit LandmarkRows(S* triangle) : R_(triangle, 4) { R_.clear(); }
  S* next() {
    if (rows_ == kRows) fold();
    return block_ + 4 * rows_++;
  }
  void fold() {
    fold_rows(R_, block_, rows_, 4, 0, 4);
    rows_ = 0;
  }

 private:
  static constexpr int kRows = 24;
  PackedTriangle<S> R_;
  int rows_ = 0;
  S block_[4 * kRows];
};

/// Rows of points whose tracks drift, in px until all are known.
template <class S, bool = kTrackWalk>
class WalkingRows {
 public:
  void begin() { track_.begin(); }
  void add(int camera, std::int32_t t_us, const Vec2<S>& r, const MeasurementModel<S>& model) {
    track_.add(camera, t_us, r, model);
  }
  /// Of the point added last: its row along axis i.
  S* row(int i) { return block_ + 8 * (track_.points() - 1) + 4 * i; }
  /// Whitens them; returns their robust cost.
  S move_to(LandmarkRows<S>* out, const MeasurementModel<S>& model) {
    const S cost = track_.weigh(model);
    track_.whiten(block_, 4, 0, 4);
    for (int i = 0; i < 2 * track_.points(); ++i) {
      S* const row = out->next();
      for (int c = 0; c < 4; ++c) row[c] = block_[4 * i + c];
    }
    return cost;
  }

 private:
  TrackNoise<S> track_;
  S block_[8 * kMaxKeyframes * kMaxCameras];
};
template <class S>
class WalkingRows<S, false> {
 public:
  void begin() {}
  void add(int, std::int32_t, const Vec2<S>&, const MeasurementModel<S>&) {}
  S* row(int) { return nullptr; }
  S move_to(LandmarkRows<S>*, const MeasurementModel<S>&) { return S(0); }
};

/// What image point z shows of landmark l, whose tangent plane is spanned by e1 and e2: residual and its derivatives by
/// (e1, e2, rho). False where the lens does not reach; the residual is zero then.
template <class S>
bool look_at(const Segment<S>& segment, const Observation& z, const Calibration<S>& theta, const Vec3<S>& g,
             const Landmark<S>& l, const Vec3<S>& e1, const Vec3<S>& e2, Vec2<S>* r, Mat<S, 2, 3>* J) {
  const Exposure<S> x = exposure_of(segment, z, theta, g, false);
  // h = R_CG m + rho t moves by R_CG e1, R_CG e2 and t.
  Vec3<S> t;
  Mat3<S> R_CG;
  Vec2<S> predicted;
  Mat<S, 2, 3> J_h;
  const bool seen = with_camera(z, theta, x.warmth, [&](const CameraCalibration<S>& camera) {
    t = camera.R_CI * (x.R_GI.transpose() * (l.o - x.p_GI)) + camera.p_CI;
    R_CG = camera.R_CI * x.R_GI.transpose();
    return project<S>(camera, R_CG * l.m + l.rho * t, &predicted, &J_h, nullptr, image_terms_at(z, theta));
  });
  r->setZero();
  if (!seen) return false;
  *r = predicted - Vec2<S>(S(z.u), S(z.v));
  const Vec3<S> a1 = R_CG * e1, a2 = R_CG * e2;
  for (int i = 0; i < 2; ++i) {
    (*J)(i, 0) = J_h.row(i).dot(a1);
    (*J)(i, 1) = J_h.row(i).dot(a2);
    (*J)(i, 2) = J_h.row(i).dot(t);
  }
  return true;
}

/// The row of a landmark that no image shows, thrown off by a step: back along its direction, where its points may be.
/// What the prior says of the direction is next to nothing, and alone would turn it.
template <class S>
void back_to_infinity(const Landmark<S>& l, S* row) {
  row[0] = row[1] = S(0);
  row[2] = S(1);
  row[3] = -l.rho;
}

/// Robust cost of landmark l, and its normal equations' triangle [3 | rhs] by QR.
template <class S>
S landmark_cost(const Segment<S>& segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                const Landmark<S>& l, S* triangle) {
  const S inverse_sigma = S(1) / model.pixel_sigma;
  const DepthPrior<S> prior = depth_prior(segment, j, l, theta, model);
  S cost = prior.r * prior.r;
  LandmarkRows<S> rows(triangle);
  S* const prior_row = rows.next();
  for (int c = 0; c < kLandmarkColumns; ++c) prior_row[c] = prior.row.l(c);
  prior_row[3] = -prior.r;
  Vec3<S> e1, e2;
  tangent_basis(l.m, &e1, &e2);
  WalkingRows<S> walking;
  walking.begin();
  bool anywhere = false;
  for (int o = segment.first_observation[j]; o < segment.first_observation[j + 1]; ++o) {
    const Observation& z = segment.observation[o];
    if (z.rejected) continue;
    Vec2<S> r;
    Mat<S, 2, 3> J;
    const bool seen = look_at(segment, z, theta, model.g, l, e1, e2, &r, &J);
    const bool walks = seen && TrackNoise<S>::walks(model);
    const RobustTerm<S> robust =
        walks ? RobustTerm<S>{S(1), S(0)}
              : robust_term(model, seen ? r.squaredNorm() * inverse_sigma * inverse_sigma : S(1e4));
    cost += robust.cost;
    if (!seen) continue;
    anywhere = true;
    const S scale = walks ? S(1) : square_root(robust.weight) * inverse_sigma;
    if (walks) walking.add(z.camera, segment.t_us[z.keyframe], r, model);
    for (int i = 0; i < 2; ++i) {
      S* const row = walks ? walking.row(i) : rows.next();
      for (int c = 0; c < 3; ++c) row[c] = scale * J(i, c);
      row[3] = -scale * r(i);
    }
  }
  if (!anywhere) back_to_infinity(l, prior_row);
  if (TrackNoise<S>::walks(model)) cost += walking.move_to(&rows, model);
  rows.fold();
  return cost;
}

/// Damped Gauss-Newton from *l, at most `steps` of them; returns the robust cost reached.
template <class S>
S refine_landmark(const Segment<S>& segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                  int steps, Landmark<S>* l) {
  S triangle[2][packed_size(4)];  // at *l, and at the trial: nearly every trial is taken
  int at = 0;
  S cost = landmark_cost<S>(segment, j, theta, model, *l, triangle[at]);
  for (int i = 0; i < steps; ++i) {
    S step[3];
    const PackedTriangle<S> R(triangle[at], 4);
    for (int c = 0; c < 3; ++c) step[c] = R(c, 3);
    back_substitute(R, 3, step);
    Landmark<S> trial;
    S trial_cost = cost;
    for (int half = 0; half < 5; ++half) {
      trial = *l;
      add_step(&trial, step);
      trial_cost = landmark_cost<S>(segment, j, theta, model, trial, triangle[1 - at]);
      if (trial_cost < cost) break;
      for (S& s : step) s *= S(0.3);
    }
    if (!(trial_cost < cost)) break;
    const bool settled = cost - trial_cost < S(1e-3) * cost;
    *l = trial;
    cost = trial_cost;
    at = 1 - at;
    if (settled) break;
  }
  return cost;
}

/// Triangulates landmark j of a segment at its keyframe states. False if no consistent point or direction is found:
/// the mean squared whitened residual stays above `limit`.
template <class S>
bool triangulate(Segment<S>* segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model, S limit) {
  Landmark<S> l;
  if (!start_landmark(*segment, j, theta, model.g, &l)) return false;
  const S cost = refine_landmark(*segment, j, theta, model, 8, &l);
  segment->states.landmark[j] = l;
  const int points = segment->first_observation[j + 1] - segment->first_observation[j];
  return is_finite(cost) && cost < limit * S(2 * points);
}

}  // namespace SEGCAL_NS
