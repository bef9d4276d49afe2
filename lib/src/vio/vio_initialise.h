// The start at rest, from gravity and the gyroscope's mean; and how a window is opened. In motion: start_motion.h.
#pragma once

#include "vio/sensor_priors.h"
#include "vio/start_refine.h"

namespace SEGCAL_NS {

/// Puts the prior of the first state and the sensors into an empty R.
template <class S>
[[gnu::cold]] void begin_window(Window<S>* w, const VioOptions<S>& options, const State<S>& x0, S sigma_v) {
  PackedTriangle<S> R = w->R();
  for (int c = 0; c < w->theta.n_cameras; ++c) w->camera_first[c] = w->theta.camera[c];
  w->clear_information();
  const StartColumns at{pose_column(0), pose_column(0) + 3, 0, camera_column(0), kMaxCameraColumns};
  fold_start_prior(options, x0, &R, at, sigma_v, options.sigma_b_a, w->block);
  if (w->learnt) {
    fold_learnt(w);
  } else {
    fold_camera_prior(*w, options, &R, at, w->block);
    for (int i = 0; i < kImuColumns; ++i) {
      if (imu_sigma(options, i) > S(0)) R.row(w->imu_column() + i)[w->imu_column() + i] = S(1) / imu_sigma(options, i);
    }
  }
  w->now = w->now_first = x0;
}

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
[[gnu::cold]] void start_at_rest(Window<S>* w, TrackTable<S>* tracks, const VioOptions<S>& options,
                                 const Origin<S>& origin, const ImuHistory<S>& imu, StartScratch<S>* s) {
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
  begin_window(w, options, s->x0, S(1));
  fold_rest(w, options, spread);
  apply_update(w);
  s->still = true;
  s->pixel_scale = S(1);
}

}  // namespace SEGCAL_NS
