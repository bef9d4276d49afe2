// The camera and reprojection models, written a second time for automatic derivatives (ceres::Jet). Nothing here is
// shared with the core but the names of parameters and the basis that a landmark's direction moves in.
#pragma once

#include <ceres/jet.h>
#include <ceres/rotation.h>

#include <Eigen/Geometry>

#include "segments/landmark.h"

namespace jet {

using namespace SEGCAL_NS;

/// atan(r) / r as a function of q = r^2, which is smooth at 0 while sqrt is not.
template <class T>
T atan_over_root(const T& q) {
  if (q < T(1e-4)) return T(1) - q / T(3) + q * q / T(5) - q * q * q / T(7);
  const T r = sqrt(q);
  return atan(r) / r;
}

/// tan(a) / a.
template <class T>
T tan_over(const T& a) {
  const T a2 = a * a;
  if (a2 < T(1e-4)) return T(1) + a2 / T(3) + T(2) * a2 * a2 / T(15) + T(17) * a2 * a2 * a2 / T(315);
  return tan(a) / a;
}

/// (x_d, y_d) for the model's coefficients d.
template <class T>
void distort(Distortion model, const T* d, const T& x, const T& y, T* xd, T* yd) {
  const T q = x * x + y * y;
  if (model == Distortion::fov) {
    const T half = d[0] / T(2), k = T(2) * tan(half);
    const T beta = atan_over_root(T(k * k * q)) * tan_over(half);
    *xd = beta * x;
    *yd = beta * y;
  } else if (model == Distortion::radtan) {
    const T radial = T(1) + d[0] * q + d[1] * q * q;
    *xd = x * radial + T(2) * d[2] * x * y + d[3] * (q + T(2) * x * x);
    *yd = y * radial + d[2] * (q + T(2) * y * y) + T(2) * d[3] * x * y;
  } else {
    const T ratio = atan_over_root(q), t2 = ratio * ratio * q;
    const T beta = ratio * (T(1) + d[0] * t2 + d[1] * t2 * t2 + d[2] * t2 * t2 * t2 + d[3] * t2 * t2 * t2 * t2);
    *xd = beta * x;
    *yd = beta * y;
  }
}

/// `k` holds fx fy cx cy and four coefficients.
template <class T>
Eigen::Matrix<T, 2, 1> project(Distortion model, const T* k, const Eigen::Matrix<T, 3, 1>& h) {
  T xd, yd;
  if (model == Distortion::equidistant && !(h[2] * h[2] > T(0.01) * (h[0] * h[0] + h[1] * h[1]) && h[2] > T(0))) {
    const T r = sqrt(h[0] * h[0] + h[1] * h[1]), a = acos(h[2] / sqrt(r * r + h[2] * h[2])), a2 = a * a;
    const T radius = a * (T(1) + k[4] * a2 + k[5] * a2 * a2 + k[6] * a2 * a2 * a2 + k[7] * a2 * a2 * a2 * a2);
    xd = radius * h[0] / r;
    yd = radius * h[1] / r;
    return {k[0] * xd + k[2], k[1] * yd + k[3]};
  }
  distort(model, k + 4, T(h[0] / h[2]), T(h[1] / h[2]), &xd, &yd);
  return {k[0] * xd + k[2], k[1] * yd + k[3]};
}

/// A rotation matrix of the core as a quaternion of T.
template <class T>
Eigen::Quaternion<T> quaternion(const Mat3<double>& R) {
  return Eigen::Quaterniond(R).normalized().cast<T>();
}

/// Exp as a quaternion (ceres' order is w x y z too).
template <class T>
Eigen::Quaternion<T> exponential(const T* v) {
  T q[4];
  ceres::AngleAxisToQuaternion(v, q);
  return Eigen::Quaternion<T>(q[0], q[1], q[2], q[3]);
}

template <class T>
Eigen::Matrix<T, 3, 1> logarithm(const Eigen::Quaternion<T>& q) {
  const T wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  Eigen::Matrix<T, 3, 1> v;
  ceres::QuaternionToAngleAxis(wxyz, v.data());
  return v;
}

constexpr int kReprojectionColumns = kLandmarkColumns + 6 + kMaxCameraColumns;

/// Predicted pixel after the step d: [landmark 3 | theta p of the keyframe | r_CI p_CI fx fy cx cy coefficients].
template <class T>
Eigen::Matrix<T, 2, 1> predict(const CameraCalibration<double>& camera, const Mat3<double>& R_GI,
                               const Vec3<double>& p_GI, const Landmark<double>& l, const T* d) {
  using V = Eigen::Matrix<T, 3, 1>;
  const auto vector = [](const T* v) { return V(v[0], v[1], v[2]); };
  Vec3<double> e1, e2;
  tangent_basis(l.m, &e1, &e2);
  const V m = l.m.cast<T>() + e1.cast<T>() * d[0] + e2.cast<T>() * d[1];
  const T rho = T(l.rho) + d[2];
  const Eigen::Quaternion<T> q_GI = quaternion<T>(R_GI) * exponential(d + 3);
  const Eigen::Quaternion<T> q_CI = exponential(d + 9) * quaternion<T>(camera.R_CI);
  const V from_camera = m + (l.o.cast<T>() - (p_GI.cast<T>() + vector(d + 6))) * rho;
  const V h = q_CI * (q_GI.conjugate() * from_camera) + (camera.p_CI.cast<T>() + vector(d + 12)) * rho;
  T k[8];
  for (int i = 0; i < 4; ++i) {
    k[i] = T(camera.intrinsics(i)) + d[15 + i];
    k[4 + i] = T(camera.distortion(i)) + d[19 + i];
  }
  return project(camera.model, k, h);
}

}  // namespace jet
