// Image residuals for automatic differentiation: any scalar with + - * / and elementary functions.
#pragma once

#include <ceres/rotation.h>

#include <cmath>

#include "reference/problem.h"

namespace host::reference {

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Vector2 = Eigen::Matrix<T, 2, 1>;

/// A rotation Exp(d) as a quaternion.
template <class T>
Eigen::Quaternion<T> turned_by(const T* d) {
  T q[4];
  ceres::AngleAxisToQuaternion(d, q);
  return Eigen::Quaternion<T>(q[0], q[1], q[2], q[3]);
}

/// Log of a unit quaternion.
template <class T>
Vector3<T> rotation_vector(const Eigen::Quaternion<T>& q) {
  const T wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  Vector3<T> out;
  ceres::QuaternionToAngleAxis(wxyz, out.data());
  return out;
}

template <class T>
T fov_radius(const T& r, const T& w) {
  using std::atan;
  using std::tan;
  return atan(T(2) * r * tan(w / T(2))) / w;
}

/// The distorted point of an undistorted one, both at z = 1.
template <class T>
Vector2<T> distorted(DistortionModel model, const T* k, const Vector2<T>& xy) {
  using std::atan2;
  using std::sqrt;
  const T r2 = xy.squaredNorm();
  if (model == DistortionModel::radtan) {
    const T x = xy.x(), y = xy.y(), radial = T(1) + k[0] * r2 + k[1] * r2 * r2;
    return Vector2<T>(x * radial + T(2) * k[2] * x * y + k[3] * (r2 + T(2) * x * x),
                      y * radial + k[2] * (r2 + T(2) * y * y) + T(2) * k[3] * x * y);
  }
  const T r = sqrt(r2 + T(1e-20));  // the centre has no direction: a picometre beside it is as good
  if (model == DistortionModel::fov) return (fov_radius(r, k[0]) / r) * xy;
  const T a = atan2(r, T(1)), a2 = a * a;
  return (a * (T(1) + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3])))) / r) * xy;
}

/// The distorted point of an equidistant lens by the angle from the axis, for directions away from it.
template <class T>
Vector2<T> equidistant(const T* k, const Vector3<T>& h) {
  using std::atan2;
  using std::sqrt;
  const T r = sqrt(h.x() * h.x() + h.y() * h.y());
  const T a = atan2(r, h.z()), a2 = a * a;
  return (a * (T(1) + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3])))) / r) * Vector2<T>(h.x(), h.y());
}

/// The distorted point of a direction. False where the models end: 80 degrees from the axis, equidistant 100.
template <class T>
bool distorted_direction(DistortionModel model, const T* k, const Vector3<T>& h, Vector2<T>* d) {
  const T length = h.norm();
  const bool ahead = h.z() > T(0.3) * length;
  if (model == DistortionModel::equidistant && !ahead) {
    *d = equidistant(k, h);
    return h.z() > T(-0.17364818) * length;
  }
  if (!(h.z() > T(0.17) * length)) return false;
  *d = distorted(model, k, Vector2<T>(h.x() / h.z(), h.y() / h.z()));
  return true;
}

// Parameter blocks. Camera: [turn of R_CI 3 | p_CI 3 | fx fy cx cy | distortion 4], R_CI = Exp(turn) R0.
// Pose: [turn 3 | p_GI 3], R_GI = R0 Exp(turn). Landmark: [shift of the direction 2 | inverse distance].
constexpr int kCameraSize = 14, kPoseSize = 6, kLandmarkSize = 3;

/// Direction with a step in its tangent plane.
struct Tangent {
  Eigen::Vector3d e1, e2;
  explicit Tangent(const Eigen::Vector3d& direction) : e1(direction.unitOrthogonal()), e2(direction.cross(e1)) {}
};

/// A landmark in the camera, times its inverse distance from the anchor.
template <class T>
Vector3<T> in_camera(const CameraCalibration& camera0, const State& state0, const Landmark& landmark0, const T* pose,
                     const T* landmark, const T* camera) {
  const Tangent tangent(landmark0.direction);
  Vector3<T> m =
      landmark0.direction.cast<T>() + landmark[0] * tangent.e1.cast<T>() + landmark[1] * tangent.e2.cast<T>();
  m.normalize();
  const T rho = landmark[2];
  const Vector3<T> p_GI(pose[3], pose[4], pose[5]);
  const Eigen::Quaternion<T> q_GI = state0.q_GI.cast<T>() * turned_by(pose);
  const Eigen::Quaternion<T> q_CI = turned_by(camera) * Eigen::Quaterniond(camera0.R_CI).cast<T>();
  const Vector3<T> from_I = m + rho * (landmark0.anchor.cast<T>() - p_GI);
  return q_CI * (q_GI.conjugate() * from_I) + rho * Vector3<T>(camera[3], camera[4], camera[5]);
}

/// Pixel of a landmark. False where it has no image.
template <class T>
bool predicted(const CameraCalibration& camera0, const State& state0, const Landmark& landmark0, const T* pose,
               const T* landmark, const T* camera, Vector2<T>* uv) {
  const Vector3<T> h = in_camera(camera0, state0, landmark0, pose, landmark, camera);
  Vector2<T> d;
  if (!distorted_direction(camera0.model, camera + 10, h, &d)) return false;
  *uv = Vector2<T>(camera[6] * d.x() + camera[8], camera[7] * d.y() + camera[9]);
  return true;
}

struct CameraResidual {
  const CameraCalibration& camera0;
  const State& state0;
  const Landmark& landmark0;
  Eigen::Vector2d uv;
  double pixel_sigma, huber;

  template <class T>
  bool operator()(const T* pose, const T* landmark, const T* camera, T* residual) const {
    Vector2<T> at;
    if (!predicted(camera0, state0, landmark0, pose, landmark, camera, &at)) {
      residual[0] = T(huber);  // out of sight: a constant
      residual[1] = T(0);
      return true;
    }
    residual[0] = (at.x() - T(uv.x())) / T(pixel_sigma);
    residual[1] = (at.y() - T(uv.y())) / T(pixel_sigma);
    return true;
  }
};

/// An image point whose error has drifted since its track began.
struct DriftingResidual {
  CameraResidual at_once;
  template <class T>
  bool operator()(const T* pose, const T* landmark, const T* camera, const T* drift, T* residual) const {
    at_once(pose, landmark, camera, residual);
    for (int i = 0; i < 2; ++i) residual[i] -= drift[i] / T(at_once.pixel_sigma);
    return true;
  }
};

/// A step of the random walk.
struct DriftStep {
  double sigma;
  template <class T>
  bool operator()(const T* from, const T* to, T* residual) const {
    for (int i = 0; i < 2; ++i) residual[i] = (to[i] - from[i]) / T(sigma);
    return true;
  }
};

}  // namespace host::reference
