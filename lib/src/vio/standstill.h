// Standing still: no new pose, no drift.
//
// While the IMU is quiet and the image does not move, the newest pose simply stays the newest pose: the window keeps its
// baseline, and the inertial link from the pose to itself tells biases and gravity. Image motion is measured
// against the frame in which the pose was last added, so a slow drift adds up and ends the standstill.
#pragma once

#include "vio/vio_propagate.h"
#include "vio/vio_tracks.h"

namespace SEGCAL_NS {

/// Mean and spread of the readings in a stretch of time.
template <class S>
struct ReadingSpread {
  InertialReading<S> mean;
  S gyro, accel;  ///< standard deviation, of the worst axis
  int samples;
};

template <class S>
ReadingSpread<S> reading_spread(const ImuHistory<S>& imu, std::int64_t t0, std::int64_t t1) {
  ReadingSpread<S> out;
  const int first = imu.at_or_before(t0), last = imu.at_or_before(t1);
  out.samples = last - first + 1;
  Vec3<S> gyro = Vec3<S>::Zero(), accel = Vec3<S>::Zero(), gyro2 = gyro, accel2 = accel;
  for (int i = first; i <= last; ++i) {
    gyro += imu.reading(i).gyro;
    accel += imu.reading(i).accel;
  }
  out.mean = {gyro / S(out.samples), accel / S(out.samples)};
  for (int i = first; i <= last; ++i) {
    gyro2 += (imu.reading(i).gyro - out.mean.gyro).cwiseAbs2();
    accel2 += (imu.reading(i).accel - out.mean.accel).cwiseAbs2();
  }
  out.gyro = square_root(gyro2.maxCoeff() / S(out.samples));
  out.accel = square_root(accel2.maxCoeff() / S(out.samples));
  return out;
}

/// Share of the tracks seen at `slot` and again in `points` that moved less than `limit` px; 0 if fewer than 8.
template <class S>
S share_not_moved(const TrackTable<S>& tracks, int slot, const TrackPoint<S>* points, int n, S limit) {
  int common = 0, still = 0;
  for (int i = 0; i < n; ++i) {
    const VioTrack<S>* track = tracks.find(points[i].id, points[i].camera);
    if (!track || !track->in(slot)) continue;
    ++common;
    if ((track->uv[slot] - points[i].uv).squaredNorm() < limit * limit) ++still;
  }
  return common < 8 ? S(0) : S(still) / S(common);
}

/// The test with what it looks at.
template <class S>
struct StillTest {
  const VioOptions<S>& options;
  const Window<S>& window;
  const TrackTable<S>& tracks;
  const ImuHistory<S>& imu;

  bool imu_quiet(std::int64_t t0, std::int64_t t1) const {
    const ReadingSpread<S> spread = reading_spread(imu, t0, t1);
    return spread.samples > 4 && spread.gyro < options.still_gyro && spread.accel < options.still_accel;
  }

  /// The newest pose against a frame at t1.
  bool still(std::int64_t t0, std::int64_t t1, const TrackPoint<S>* points, int n) const {
    if (window.now.v_GI.squaredNorm() > S(0.04) || !imu_quiet(t0, t1)) return false;
    return share_not_moved(tracks, window.newest().slot, points, n, options.still_pixels * S(1.5)) > S(0.6);
  }
};

/// Three rows of weight 1/sigma on columns [column, column + 3) with right-hand side -value/sigma: a measurement of 0.
template <class S>
S fold_zero(Window<S>* w, int column, const Vec3<S>& value, S sigma) {
  w->clear_block(3);
  for (int i = 0; i < 3; ++i) {
    w->block[i * kBlockStride + column + i] = S(1) / sigma;
    w->block[i * kBlockStride + w->columns()] = -value(i) / sigma;
  }
  return fold_block(w, w->block, 3, column);
}

/// The newest state moves on to t1 without moving: same pose, velocity zero. What a thing on a floor may do between
/// two frames is added to the link's noise. False, and nothing changed, if the filter does not believe it.
template <class S>
bool propagate_still(Window<S>* w, const VioOptions<S>& options, const ImuHistory<S>& imu, std::int64_t t0,
                     std::int64_t t1) {
  ImuIntegral<S> I = integral_between(*w, options, imu, w->now, t0, t1);
  for (int i = 0; i < 3; ++i) {
    I.P(i, i) += S(1e-8);          // 0.1 mrad
    I.P(3 + i, 3 + i) += S(1e-6);  // 1 mm/s
    I.P(6 + i, 6 + i) += S(1e-8);  // 0.1 mm
  }
  link_rows<S>(I, w->now, w->now, w->now_first, w->now_first, options.g, &w->link);
  if (!whiten(I, options.noise, &w->link)) return false;
  for (int i = 0; i < w->triangle_size(); ++i) w->saved[i] = w->triangle[i];
  const int newest = w->n_poses - 1;
  S distance = fold_link(w, newest, newest);
  distance += fold_zero(w, 0, w->now.v_GI, options.still_velocity_sigma);
  if (!(distance < S(40))) {  // 9 degrees of freedom; generous, the start of a standstill is rough
    for (int i = 0; i < w->triangle_size(); ++i) w->triangle[i] = w->saved[i];
    return false;
  }
  w->now_first.v_GI = w->now.v_GI;
  w->now_first.b_a = w->now.b_a;
  w->now_first.b_g = w->now.b_g;
  apply_update(w);
  return true;
}

}  // namespace SEGCAL_NS
