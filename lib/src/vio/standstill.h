// Standing still: no new pose, no drift.
//
// While the IMU is quiet and the image does not move, the newest pose simply stays the newest pose: the window keeps
// its baseline, and the inertial link from the pose to itself tells biases and gravity. Image motion is measured
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

/// Common motion of image points between two frames: shift, and growth and roll about their centre. Averaged over the
/// tracks, so that the tracker's noise does not look like motion and a slow motion does not hide in it.
template <class S>
class ImageMotion {
 public:
  void add(const Vec2<S>& from, const Vec2<S>& to) {
    const Vec2<S> d = to - from;
    ++seen_;
    if (!(d.squaredNorm() < S(9))) return;  // 3 px: a mismatch, or no standstill
    ++close_;
    shift_ += d;
    place_ += from;
    along_ += d.dot(from);
    across_ += from.x() * d.y() - from.y() * d.x();
    square_ += from.squaredNorm();
  }

  /// Less than `limit` px for a point at the usual distance from the centre; needs 8 tracks, most of them close.
  bool none(S limit) const {
    if (seen_ < 8 || S(close_) < S(0.7) * S(seen_)) return false;
    const S n = S(close_);
    const Vec2<S> d = shift_ / n, c = place_ / n;
    const S spread = square_ / n - c.squaredNorm();
    const S growth = along_ / n - d.dot(c), roll = across_ / n - (c.x() * d.y() - c.y() * d.x());
    const S limit2 = limit * limit;
    return d.squaredNorm() < limit2 && growth * growth < limit2 * spread && roll * roll < limit2 * spread;
  }

 private:
  int seen_ = 0, close_ = 0;
  Vec2<S> shift_ = Vec2<S>::Zero(), place_ = Vec2<S>::Zero();
  S along_ = S(0), across_ = S(0), square_ = S(0);
};

/// The test with what it looks at.
template <class S>
struct StillTest {
  const VioOptions<S>& options;
  const Window<S>& window;
  const TrackTable<S>& tracks;
  const ImuHistory<S>& imu;

  /// How much the IMU shakes, in units of what rest allows. A hand that holds still for a tenth of a second is not a
  /// floor: look back a little further.
  S shaking(std::int64_t t1) const {
    const std::int64_t t0 = t1 - 300000000;
    if (!imu.covers(t0, t1)) return S(1e3);
    const ReadingSpread<S> spread = reading_spread(imu, t0, t1);
    if (spread.samples < 5) return S(1e3);
    const S gyro = spread.gyro / options.still_gyro, accel = spread.accel / options.still_accel;
    return gyro > accel ? gyro : accel;
  }

  /// No common motion between the frame of a pose and the points of the present one.
  bool image_stays(const WindowPose<S>& pose, const TrackPoint<S>* points, int n) const {
    ImageMotion<S> motion;
    for (int i = 0; i < n; ++i) {
      const VioTrack<S>* track = tracks.find(points[i].id, points[i].camera);
      if (track && track->in(pose.slot)) motion.add(track->uv[pose.slot], points[i].uv);
    }
    return motion.none(options.still_pixels);
  }

  /// The newest pose against a frame at t1. A quiet IMU and an image that stays since the last frame are enough. If the
  /// IMU shakes (touching down, motors that start) the image must have stayed for half a second; in a standstill it
  /// is compared with the frame in which that began anyway.
  bool still(std::int64_t t1, bool stands_already, const TrackPoint<S>* points, int n) const {
    if (window.now.v_GI.squaredNorm() > S(0.04)) return false;
    const S shakes = shaking(t1);
    if (!(shakes < S(25)) || !image_stays(window.newest(), points, n)) return false;
    if (shakes < S(1) || stands_already) return true;
    return window.n_poses >= 5 && image_stays(window.pose[window.n_poses - 5], points, n);
  }

  /// Rest beyond doubt, whatever the filter believes: the IMU is quiet and the image has stayed for half a second.
  bool rests(std::int64_t t1, const TrackPoint<S>* points, int n) const {
    return shaking(t1) < S(1) && window.n_poses >= 5 && image_stays(window.newest(), points, n) &&
           image_stays(window.pose[window.n_poses - 5], points, n);
  }
};

/// Three rows of weight 1/sigma on columns [column, column + 3) with right-hand side -value/sigma: a measurement of 0.
template <class S>
void zero_rows(S* rows, int column, int rhs, const Vec3<S>& value, S sigma) {
  for (int i = 0; i < 3; ++i) {
    rows[i * kBlockStride + column + i] = S(1) / sigma;
    rows[i * kBlockStride + rhs] = -value(i) / sigma;
  }
}

template <class S>
void fold_zero(Window<S>* w, int column, const Vec3<S>& value, S sigma) {
  w->clear_block(3);
  zero_rows(w->block, column, w->columns(), value, sigma);
  fold_block(w, w->block, 3, column);
}

/// Mahalanobis distance of a standstill link (whitened, in w->link) with zero velocity after it: the new motion is
/// eliminated, y = R^-T h for each of the nine rows h that are left, and y y' + 1 is the covariance of the innovations.
template <class S>
S still_distance(Window<S>* w, S sigma_v) {
  constexpr int rows = kLinkRows + 3, dof = rows - kMotionColumns;
  const int newest = w->n_poses - 1, n = w->columns();
  w->clear_block(rows);
  place_link(w, 0, kMotionColumns, 0, newest, newest);
  zero_rows(w->block + kLinkRows * kBlockStride, 0, kMotionColumns + n, w->now.v_GI, sigma_v);
  reflect_leading_columns(w->block, rows, kBlockStride, n + 1 + kMotionColumns, kMotionColumns, w->work);
  Mat<S, dof, dof> C, L;
  Vec<S, dof> z;
  S distance = S(0);
  for (int i = 0; i < dof; ++i) {
    S* y = w->block + (kMotionColumns + i) * kBlockStride + kMotionColumns;
    forward_substitute(w->R(), n, 0, y);
    for (int k = 0; k <= i; ++k) {
      C(i, k) = C(k, i) = factor_product(y, w->block + (kMotionColumns + k) * kBlockStride + kMotionColumns, n);
    }
    C(i, i) += S(1);
    z(i) = y[n];
  }
  if (!cholesky_lower<S, dof>(C, &L)) return S(2) * chi_square_gate<S>(dof);
  for (int i = 0; i < dof; ++i) {
    for (int k = 0; k < i; ++k) z(i) -= L(i, k) * z(k);
    z(i) /= L(i, i);
    distance += z(i) * z(i);
  }
  return distance;
}

/// The newest state moves on to t1 without moving: same pose, velocity zero. What a thing on a floor may do between
/// two frames is added to the link's noise, more if it shakes. False, and nothing changed, if the filter does not
/// believe it.
template <class S>
bool propagate_still(Window<S>* w, const VioOptions<S>& options, const ImuHistory<S>& imu, std::int64_t t0,
                     std::int64_t t1, S shaking) {
  ImuIntegral<S> I = integral_between(*w, options, imu, w->now, t0, t1);
  const S more = shaking < S(1) ? S(1) : S(2) * shaking;
  for (int i = 0; i < 3; ++i) {
    I.P(i, i) += more * more * S(2.5e-7);          // 0.5 mrad
    I.P(3 + i, 3 + i) += more * more * S(2.5e-5);  // 5 mm/s
    I.P(6 + i, 6 + i) += more * more * S(2.5e-7);  // 0.5 mm
  }
  if (!linearise_link(w, options, I, w->now, w->now_first)) return false;
  if (!(still_distance(w, more * options.still_velocity_sigma) < chi_square_gate<S>(kMotionColumns))) return false;
  fold_link(w, w->n_poses - 1, w->n_poses - 1);
  fold_zero(w, 0, w->now.v_GI, more * options.still_velocity_sigma);
  w->now_first.v_GI = w->now.v_GI;
  w->now_first.b_a = w->now.b_a;
  w->now_first.b_g = w->now.b_g;
  apply_update(w);
  return true;
}

}  // namespace SEGCAL_NS
