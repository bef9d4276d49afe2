// What the image says about motion, without the filter.
#pragma once

#include "math/elementary.h"
#include "sensors/camera.h"

namespace SEGCAL_NS {

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

  bool seen_enough() const { return seen_ >= kFewest; }

  /// Less than `limit` px for a point at the usual distance from the centre; needs 8 tracks, most of them close.
  bool none(S limit) const { return less(limit, S(1)); }

  /// Less than what a translation by `share` of the points' distance can do: a shift of share f, and a growth that is
  /// the smaller the nearer the points are to the centre.
  bool no_translation(S share, S focal) const { return less(share * focal, S(1) / focal); }

 private:
  static constexpr int kFewest = 8;
  /// `growth_by`: 1, or 1 px by the focal length: then the limit of the growth shrinks with the points' spread.
  bool less(S limit, S growth_by) const {
    if (!seen_enough() || S(close_) < S(0.7) * S(seen_)) return false;
    const S n = S(close_);
    const Vec2<S> d = shift_ / n, c = place_ / n;
    const S spread = square_ / n - c.squaredNorm();
    const S growth = along_ / n - d.dot(c), roll = across_ / n - (c.x() * d.y() - c.y() * d.x());
    const S limit2 = limit * limit, seen_growth = growth_by == S(1) ? spread : spread * spread * growth_by * growth_by;
    return d.squaredNorm() < limit2 && growth * growth < limit2 * seen_growth && roll * roll < limit2 * spread;
  }

  int seen_ = 0, close_ = 0;
  Vec2<S> shift_ = Vec2<S>::Zero(), place_ = Vec2<S>::Zero();
  S along_ = S(0), across_ = S(0), square_ = S(0);
};

/// The motion in the images of all cameras. Cameras look in different directions,
/// and what shifts one image to the left may shift another to the right: each is
/// asked alone. All that see enough must agree, and at least one must see enough.
template <class S>
class RigMotion {
 public:
  void add(int camera, const Vec2<S>& from, const Vec2<S>& to) { camera_[camera].add(from, to); }

  /// `says`: (camera, its motion) to yes or no.
  template <class Says>
  bool all(Says says) const {
    int asked = 0;
    for (int c = 0; c < kMaxCameras; ++c) {
      if (!camera_[c].seen_enough()) continue;
      if (!says(c, camera_[c])) return false;
      ++asked;
    }
    return asked > 0;
  }

 private:
  ImageMotion<S> camera_[kMaxCameras];
};

/// Where a point at `uv` is seen after the device has turned in place; R_turn takes directions in I before to I after.
template <class S>
bool turned_point(const CameraCalibration<S>& camera, const Mat3<S>& R_turn, const Vec2<S>& uv, Vec2<S>* out) {
  Vec3<S> h_C;
  if (!unproject(camera, uv, &h_C)) return false;
  const Vec3<S> h_I = camera.R_CI.transpose() * h_C;
  return project(camera, Vec3<S>(camera.R_CI * (R_turn * h_I)), out);
}

}  // namespace SEGCAL_NS
