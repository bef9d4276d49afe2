// Values as results print them, rotations as rotation vectors, and how they follow from theta's columns.
#pragma once

#include "calibration/course.h"
#include "calibration/prior.h"
#include "math/so3.h"

namespace SEGCAL_NS {

/// A printed value's change as a sum over theta's columns: the column itself, or, for
/// a component of a rotation vector v, row i of J_l^-1(v): theta's columns are the
/// small rotation Exp(d) R, and the rotation vector of Exp(d) R moves by J_l^-1(v) d.
template <class S>
struct PrintedValue {
  int first = 0, count = 1;
  S weight[3] = {S(1), S(0), S(0)};
};

/// The rotation that column i of theta belongs to, and its first column; null if it is no rotation's.
template <class Theta>
auto rotation_of(Theta* theta, int i, int* first) -> decltype(&theta->imu.R_AI) {
  for (int c = 0; c < theta->n_cameras; ++c) {
    *first = theta->camera_column(c);
    if (i >= *first && i < *first + 3) return &theta->camera[c].R_CI;
  }
  *first = theta->imu_column() + kImuColumns - 3;
  return i >= *first && i < *first + 3 ? &theta->imu.R_AI : nullptr;
}

/// A rotation as printed: the rotation vector nearest to the mean's. Cameras of phones are half a turn from the IMU,
/// where the shortest vector jumps to its opposite, and components of the two must not be compared or mixed.
template <class S>
Vec3<S> printed_rotation(const Mat3<S>& R_mean, const Mat3<S>& R) {
  return so3_log_near<S>(R, so3_log<S>(R_mean));
}

template <class S>
PrintedValue<S> printed_value(const Calibration<S>& mean, const Calibration<S>& theta, int i) {
  PrintedValue<S> value;
  const Mat3<S>* R = rotation_of(&theta, i, &value.first);
  if (!R) {
    value.first = i;
    return value;
  }
  const Vec3<S> v = printed_rotation(*rotation_of(&mean, i, &value.first), *R);
  const Mat3<S> J = so3_right_jacobian_inverse<S>(Vec3<S>(-v));  // left is right of the negative
  value.count = 3;
  for (int k = 0; k < 3; ++k) value.weight[k] = J(i - value.first, k);
  return value;
}

/// How far it may lag over sessions (calibration/course.h).
template <class S>
S printed_lag(const Course<S>& course, const PrintedValue<S>& value) {
  S lag = S(0);
  for (int k = 0; k < value.count; ++k) lag += absolute(value.weight[k]) * course.lag[value.first + k];
  return lag;
}

template <class S>
S printed_lag(const NoCourse&, const PrintedValue<S>&) {
  return S(0);
}

/// Its sigma before anything was measured.
template <class S>
S sigma_before(const PrintedValue<S>& value, const S* prior_sigma) {
  S sum = S(0);
  for (int k = 0; k < value.count; ++k) {
    const S s = value.weight[k] * prior_sigma[value.first + k];
    sum += s * s;
  }
  return square_root(sum);
}

}  // namespace SEGCAL_NS
