// What filter and segments share of triangulation: the first guess of a landmark from the rays of its track, and how
// far away landmarks are taken to be.
//
// What follows differs, and stays apart: the filter takes a few plain Gauss-Newton steps within the time of a frame
// (vio_triangulate.h); a segment's fit is robust, knows the track's drift and what a rolling shutter or a time offset
// move, and never takes a step that makes it worse (triangulation.h).
#pragma once

#include "segments/landmark.h"

namespace SEGCAL_NS {

// Sigmas of the inverse distance about zero, 1/m: a landmark is somewhere, or anywhere beyond. They hardly touch a
// landmark with parallax. Without parallax they keep the noise of the points from becoming a near landmark, which would
// seem to tell about the camera's translation.

/// Segments: a landmark is hardly nearer than 0.15 m. Wider (20 1/m), and tracks with hardly any parallax fit the noise
/// along a flat valley, as landmarks 6 cm away, where float and double end 0.06 sigma apart. Narrower (1 1/m), and what
/// is 15 cm away is pulled off its place.
template <class S>
constexpr S kSegmentDepthSigma = S(5);
/// A segment whose images show no translation: a hundred landmarks pulled towards zero together would tell the scale of
/// the map there, and so p_CI (at 2 1/m to a tenth, at 20 1/m not at all).
template <class S>
constexpr S kTurnedDepthSigma = S(20);
/// No landmark is behind the camera, but noise may put one at infinity there, by this much (20 m behind). Images alone
/// are the same for the path and landmarks mirrored, rho and all positions with the other sign: where the IMU tells
/// little, a fit with a prior that is even in rho ends there.
template <class S>
constexpr S kBehindDepthSigma = S(0.05);
/// The filter, whose pull comes anew with each part of a track.
template <class S>
constexpr S kFilterDepthSigma = S(5);
/// The filter where the position is known anyway (standstill.h): hundreds of near landmarks that all want to be farther
/// away stretch the path, by millimetres at half a metre.
template <class S>
constexpr S kHeldDepthSigma = S(50);

/// No first guess is nearer than 0.2 m, 1/m: from there a fit gets anywhere.
template <class S>
constexpr S kNearestGuess = S(5);

/// The ray of image point uv: the camera's position and the unit direction, in G. False where the lens does not reach.
template <class S>
bool ray_in_world(const CameraCalibration<S>& camera, const Mat3<S>& R_GI, const Vec3<S>& p_GI, const Vec2<S>& uv,
                  Vec3<S>* o, Vec3<S>* m) {
  Vec3<S> h_C;
  if (!unproject(camera, uv, &h_C)) return false;
  const Mat3<S> R_GC = R_GI * camera.R_CI.transpose();
  *o = p_GI - R_GC * camera.p_CI;
  *m = R_GC * (h_C / square_root(h_C.squaredNorm()));
  return true;
}

/// The direction of the first ray, and the inverse distance by least squares from all others: a ray m from o sees
/// l = o_0 + m_0 / rho where m x (m_0 + rho (o_0 - o)) = 0, linear in rho.
template <class S>
class LandmarkGuess {
 public:
  /// `first`: o and m of the first ray; rho comes with finish().
  explicit LandmarkGuess(Landmark<S>* first) : l_(first) {}
  void add(const Vec3<S>& o, const Vec3<S>& m) {
    const Vec3<S> a = cross<S>(m, l_->m), b = cross<S>(m, Vec3<S>(l_->o - o));
    above_ -= a.dot(b);
    below_ += b.dot(b);
  }
  void finish() {
    const S rho = below_ > S(1e-10) ? above_ / below_ : S(0);
    l_->rho = !(rho > S(0)) ? S(0) : rho > kNearestGuess<S> ? kNearestGuess<S> : rho;
  }

 private:
  Landmark<S>* l_;
  S above_ = S(0), below_ = S(0);
};

}  // namespace SEGCAL_NS
