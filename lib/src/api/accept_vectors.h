// The way in for vectors and rotations of the C API.
#pragma once

#include "api/accept.h"
#include "math/so3.h"

namespace SEGCAL_NS {

template <int N, class S>
bool accept_vector(const double* v, double least, double most, Vec<S, N>* out) {
  return accept(v, N, least, most, out->data());
}

/// {0,0,0,0} is the identity; false for a quaternion that is neither that nor of unit length within 1 %.
template <class S>
bool accept_rotation(const double* q, Mat3<S>* R) {
  Vec<S, 4> out;
  if (!accept_vector<4>(q, -2, 2, &out)) return false;
  const double n2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  R->setIdentity();
  if (n2 == 0) return true;
  if (n2 < 0.98 || n2 > 1.02) return false;
  *R = matrix_from_quaternion<S>(out);
  return true;
}

}  // namespace SEGCAL_NS
