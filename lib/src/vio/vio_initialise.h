// The start: at rest from gravity and the gyroscope's mean, in motion from tracks and inertial integrals.
#pragma once

#include "vio/start_alignment.h"
#include "vio/start_gyro_bias.h"
#include "vio/start_refine.h"

namespace SEGCAL_NS {

constexpr int kStartFrames = kWindow < 8 ? kWindow : 8;  // fewer frames than this are not tried

/// Folds the prior of the first state, then carries the information through the window by its inertial links.
/// Estimates and first estimates are those of place_poses().
template <class S>
bool open_window(Window<S>* w, const VioOptions<S>& options, const ImuHistory<S>& imu, const State<S>& x0, S sigma_v) {
  PackedTriangle<S> R = w->R();
  for (int c = 0; c < w->theta.n_cameras; ++c) w->camera_first[c] = w->theta.camera[c];
  w->clear_information();
  const StartColumns at{pose_column(0), pose_column(0) + 3, 0, camera_column(0), kMaxCameraColumns};
  fold_start_prior(options, x0, &R, at, sigma_v, w->block);
  if (w->learnt) {
    fold_learnt(w);
  } else {
    fold_camera_prior(*w, options, &R, at, w->block);
    for (int i = 0; i < kImuColumns; ++i) {
      if (imu_sigma(options, i) > S(0)) R.row(w->imu_column() + i)[w->imu_column() + i] = S(1) / imu_sigma(options, i);
    }
  }
  w->now = w->now_first = x0;
  for (int i = 1; i < w->n_poses; ++i) {
    const ImuIntegral<S> I = integral_between(*w, options, imu, w->now, w->pose[i - 1].time, w->pose[i].time);
    State<S> x1 = predicted(I, w->now, options.g);
    if (!linearise_link(w, options, I, x1, x1)) return false;
    w->link.r.setZero();
    fold_link(w, i - 1, i);
    w->pose[i].R_GI = w->pose[i].R_first = x1.R_GI;
    w->pose[i].p_GI = w->pose[i].p_first = x1.p_GI;
    w->now = w->now_first = x1;
  }
  return true;
}

// ---- At rest ----------------------------------------------------------------------------------------------------

/// True if nothing moved over the whole window, which is at least half a second long.
template <class S>
bool window_at_rest(const Window<S>& w, const TrackTable<S>& tracks, const VioOptions<S>& options,
                    const ImuHistory<S>& imu) {
  const std::int64_t t0 = w.pose[0].time, t1 = w.newest().time;
  if (S(t1 - t0) * S(1e-9) < S(0.45)) return false;
  const ReadingSpread<S> spread = reading_spread(imu, t0, t1);
  if (spread.gyro > options.still_gyro || spread.accel > options.still_accel) return false;
  const int first = w.pose[0].slot, last = w.newest().slot;
  RigMotion<S> motion;
  for (int k = 0; k < tracks.end(); ++k) {
    const VioTrack<S>& track = tracks[k];
    if (track.used && track.in(first) && track.in(last)) {
      motion.add(track.camera, track.uv[first], track.uv[last]);
    }
  }
  return motion.all([&](int, const ImageMotion<S>& camera) { return camera.none(options.still_pixels); });
}

/// What rest tells: v = 0, b_g = mean rate, and mean specific force = R_IG (-g) + b_a.
template <class S>
void fold_rest(Window<S>* w, const VioOptions<S>& options, const ReadingSpread<S>& spread) {
  fold_zero(w, 0, w->now.v_GI, options.still_velocity_sigma);
  fold_zero(w, 6, Vec3<S>(w->now.b_g - spread.mean.gyro), S(5e-4));
  const Vec3<S> f = w->now.R_GI.transpose() * Vec3<S>(-options.g);
  const Vec3<S> r = f + w->now.b_a - spread.mean.accel;
  const Mat3<S> by_theta = skew(f);
  const S weight = S(1) / S(0.01);
  w->clear_block(3);
  for (int i = 0; i < 3; ++i) {
    S* row = w->block + i * kBlockStride;
    row[3 + i] = weight;
    for (int c = 0; c < 3; ++c) row[pose_column(0) + c] = weight * by_theta(i, c);
    row[w->columns()] = -weight * r(i);
  }
  fold_block(w, w->block, 3, 0);
}

/// Starts with one pose, the newest frame's.
template <class S>
bool start_at_rest(Window<S>* w, TrackTable<S>* tracks, const VioOptions<S>& options, const Origin<S>& origin,
                   const ImuHistory<S>& imu, StartScratch<S>* s) {
  const ReadingSpread<S> spread = reading_spread(imu, w->pose[0].time, w->newest().time);
  while (w->n_poses > 1) {
    tracks->forget_slot(w->pose[0].slot);
    w->forget_oldest();
  }
  s->x0 = State<S>();
  s->x0.R_GI = origin.attitude(Vec3<S>(-spread.mean.accel), options.g);
  s->x0.p_GI = origin.p_GI;
  s->x0.b_g = spread.mean.gyro;
  w->pose[0].R_GI = w->pose[0].R_first = s->x0.R_GI;
  w->pose[0].p_GI = w->pose[0].p_first = s->x0.p_GI;
  if (!open_window(w, options, imu, s->x0, S(1))) return false;
  fold_rest(w, options, spread);
  apply_update(w);
  s->still = true;
  s->pixel_scale = S(1);
  return true;
}

// ---- In motion --------------------------------------------------------------------------------------------------

/// Standard deviation of entries [column, column + 3) of a triangle's solution, the largest.
template <class S>
S largest_sigma(const PackedTriangle<S>& R, int column, S* y) {
  S worst = S(0);
  for (int c = column; c < column + 3; ++c) {
    covariance_factor(R, R.columns() - 1, c, y);
    const S variance = factor_product<S>(y, y, R.columns() - 1);
    if (variance > worst) worst = variance;
  }
  return square_root(worst);
}

/// Is the fit one to fly with: most tracks agree, residuals are what pixel_sigma says, velocity and tilt are known?
/// In a wrong minimum (rotation with little parallax) many tracks miss by some pixel_sigma, and a window that has too
/// little to tell has large sigmas: both wait for better frames.
template <class S>
bool acceptable(Window<S>* w, const RefineFit<S>& fit, const PackedTriangle<S>& R, StartScratch<S>* s) {
  if (fit.tracks < 8 || fit.points < 60) return false;
  const S dof = S(2 * fit.points - 3 * fit.tracks);
  const S ratio = fit.cost / (dof > S(1) ? dof : S(1));
  s->pixel_scale = ratio < S(1) ? S(1) : square_root(ratio < S(16) ? ratio : S(16));
  if (ratio > S(2.25) || S(fit.good) < S(0.8) * S(fit.tried)) return false;
  return s->pixel_scale * largest_sigma(R, 6, w->block) < S(0.1) && largest_sigma(R, 0, w->block) < S(0.05) &&
         s->x0.v_GI.squaredNorm() < S(36);
}

/// The linear alignment may end near a wrong minimum if the device turns more than it moves. Hands move slowly:
/// descends once more, from zero velocity, and keeps the better of the two fits.
template <class S>
RefineFit<S> better_from_rest(Window<S>* w, const TrackTable<S>& tracks, const VioOptions<S>& options,
                              const Origin<S>& origin, const ImuHistory<S>& imu, StartScratch<S>* s,
                              PackedTriangle<S>* R, const RefineFit<S>& aligned) {
  s->aligned = s->x0;
  for (int c = 0; c < w->theta.n_cameras; ++c) {
    s->aligned_camera[c] = w->theta.camera[c];
    w->theta.camera[c] = w->given.camera[c];
  }
  s->x0.R_GI = origin.attitude(mean_gravity(*w, *s, square_root(options.g.squaredNorm())), options.g);
  s->x0.v_GI = s->x0.b_a = Vec3<S>::Zero();
  const RefineFit<S> fit = refine_start(w, tracks, options, imu, s, R);
  if (fit.cost < aligned.cost) return fit;
  s->x0 = s->aligned;
  for (int c = 0; c < w->theta.n_cameras; ++c) w->theta.camera[c] = s->aligned_camera[c];
  return linearise_start(w, tracks, options, imu, s, R);
}

/// Gyroscope bias, linear alignment, refinement, check.
template <class S>
bool start_in_motion(Window<S>* w, TrackTable<S>* tracks, const VioOptions<S>& options, const Origin<S>& origin,
                     const ImuHistory<S>& imu, StartScratch<S>* s) {
  s->x0 = State<S>();
  s->still = false;
  for (int c = 0; c < w->theta.n_cameras; ++c) w->theta.camera[c] = w->given.camera[c];
  estimate_gyro_bias(*w, *tracks, options, imu, s);
  if (!align(w, *tracks, options, origin, s)) return false;
  PackedTriangle<S> R(w->triangle, kStateColumns + kExtrinsicColumns * w->theta.n_cameras + 1);
  RefineFit<S> fit = refine_start(w, *tracks, options, imu, s, &R);
  fit = better_from_rest(w, *tracks, options, origin, imu, s, &R, fit);
  if (!acceptable(w, fit, R, s)) return false;
  if (discard_misfits(w, tracks, options, s->pixel_scale) > 0) {
    fit = refine_start(w, *tracks, options, imu, s, &R);
    if (!acceptable(w, fit, R, s)) return false;
  }
  return open_window(w, options, imu, s->x0, S(3));
}

/// Tries to start from the frames collected in the window. On failure the window still collects.
template <class S>
bool initialise(Window<S>* w, TrackTable<S>* tracks, StartScratch<S>* s, const VioOptions<S>& options,
                const Origin<S>& origin, const ImuHistory<S>& imu) {
  if (window_at_rest(*w, *tracks, options, imu)) return start_at_rest(w, tracks, options, origin, imu, s);
  if (w->n_poses < kStartFrames) return false;
  if (start_in_motion(w, tracks, options, origin, imu, s)) return true;
  for (int c = 0; c < w->theta.n_cameras; ++c) w->theta.camera[c] = w->given.camera[c];
  return false;
}

}  // namespace SEGCAL_NS
