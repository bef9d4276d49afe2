// Short names for the small fixed-size matrices of the core. Nothing here allocates.
#pragma once

#if defined(SEGCAL_ASSERT) && SEGCAL_ASSERT
#include "segcal/port.h"
#define eigen_assert(condition) SEGCAL_PORT_ASSERT(condition)  // Eigen's own checks, also with NDEBUG
#endif
#include <Eigen/Core>
#include <cstdint>

#include "segcal/config.h"

namespace SEGCAL_NS {

template <class S, int R, int C>
using Mat = Eigen::Matrix<S, R, C>;
template <class S, int N>
using Vec = Eigen::Matrix<S, N, 1>;
template <class S>
using Vec2 = Vec<S, 2>;
template <class S>
using Vec3 = Vec<S, 3>;
template <class S>
using Mat3 = Mat<S, 3, 3>;

/// [v]x, so that skew(a) * b = a x b.
template <class S>
Mat3<S> skew(const Vec3<S>& v) {
  Mat3<S> m;
  m(0, 0) = m(1, 1) = m(2, 2) = S(0);
  m(0, 1) = -v.z();
  m(0, 2) = v.y();
  m(1, 0) = v.z();
  m(1, 2) = -v.x();
  m(2, 0) = -v.y();
  m(2, 1) = v.x();
  return m;
}

template <class S>
Vec3<S> cross(const Vec3<S>& a, const Vec3<S>& b) {
  return Vec3<S>(a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x());
}

/// Products of 3 x 3 matrices, one copy in the code for all who multiply: as Eigen's expressions they are unrolled anew
/// in each place (27 products; or nine calls, where the inliner's budget is spent). Sums run from left to right.
template <class S, class A, class B>
Mat3<S> product3(const A& a, const B& b) {
  Mat3<S> out;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) out(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
  return out;
}
template <class S>
[[gnu::noinline]] Mat3<S> operator*(const Mat3<S>& a, const Mat3<S>& b) {
  return product3<S>(a, b);
}
template <class S>
[[gnu::noinline]] Mat3<S> operator*(const Mat3<S>& a, const Eigen::Transpose<const Mat3<S>>& b) {
  return product3<S>(a, b);
}
template <class S>
[[gnu::noinline]] Mat3<S> operator*(const Eigen::Transpose<const Mat3<S>>& a, const Mat3<S>& b) {
  return product3<S>(a, b);
}
template <class S>
Mat3<S> operator*(const Mat3<S>& a, const Eigen::Transpose<Mat3<S>>& b) {
  const Mat3<S>& whole = b.nestedExpression();
  return a * whole.transpose();
}
template <class S>
Mat3<S> operator*(const Eigen::Transpose<Mat3<S>>& a, const Mat3<S>& b) {
  const Mat3<S>& whole = a.nestedExpression();
  return whole.transpose() * b;
}

}  // namespace SEGCAL_NS
