// Substitution in triangles, and Cholesky factors: the solvers of small dense systems.
#pragma once

#include "math/elementary.h"
#include "math/packed_triangle.h"
#include "math/types.h"

namespace SEGCAL_NS {

/// y[c] += a x[c] for c in [first, last).
template <class S>
inline void add_scaled(S* __restrict y, S a, const S* __restrict x, int first, int last) {
  for (int c = first; c < last; ++c) y[c] += a * x[c];
}

/// `sum` without r[c] x[c] for c in [first, last), taken off one after the other.
template <class S>
inline S less_products(S sum, const S* r, const S* x, int first, int last) {
  for (int c = first; c < last; ++c) sum -= r[c] * x[c];
  return sum;
}

/// An unknown from what its row leaves over. A pivot that is exactly zero says nothing: the unknown stays at zero.
template <class S>
inline S over_pivot(S sum, S pivot) {
  return pivot == S(0) ? S(0) : sum / pivot;
}

/// Solves R[0..n, 0..n] x = rhs in place (x overwrites rhs).
template <class S>
void back_substitute(const PackedTriangle<S>& R, int n, S* rhs) {
  for (int j = n - 1; j >= 0; --j) {
    const S* r = R.row(j);
    rhs[j] = over_pivot(less_products(rhs[j], r, rhs, j + 1, n), r[j]);
  }
}

/// y <- R^-T y (n columns), y zero before `first`.
template <class S>
void forward_substitute(const PackedTriangle<S>& R, int n, int first, S* y) {
  for (int j = first; j < n; ++j) {
    const S* r = R.row(j);
    y[j] = over_pivot(y[j], r[j]);
    add_scaled(y, -y[j], r, j + 1, n);
  }
}

/// y = R^-T e_column (n columns): the dot products of such vectors are the entries of the covariance R^-1 R^-T.
template <class S>
void covariance_factor(const PackedTriangle<S>& R, int n, int column, S* y) {
  for (int j = 0; j < n; ++j) y[j] = S(0);
  y[column] = S(1);
  forward_substitute(R, n, column, y);
}

template <class S>
S factor_product(const S* a, const S* b, int n) {
  S sum = S(0);
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// x <- L^-1 x, of a small lower triangle.
template <class S, int N>
void forward_substitute(const Mat<S, N, N>& L, S* x) {
  for (int i = 0; i < N; ++i) {
    for (int k = 0; k < i; ++k) x[i] -= L(i, k) * x[k];
    x[i] /= L(i, i);
  }
}

/// x <- L^-T x.
template <class S, int N>
void back_substitute(const Mat<S, N, N>& L, S* x) {
  for (int i = N - 1; i >= 0; --i) {
    for (int k = i + 1; k < N; ++k) x[i] -= L(k, i) * x[k];
    x[i] /= L(i, i);
  }
}

/// Lower Cholesky factor of a small symmetric positive matrix, in its place: what is above the diagonal stays as it
/// was. False if a pivot is not positive.
template <class S, int N>
bool cholesky_in_place(Mat<S, N, N>* A) {
  Mat<S, N, N>& L = *A;
  for (int j = 0; j < N; ++j) {
    S d = L(j, j);
    for (int k = 0; k < j; ++k) d -= L(j, k) * L(j, k);
    if (!(d > S(0))) return false;
    const S pivot = square_root(d);
    L(j, j) = pivot;
    for (int i = j + 1; i < N; ++i) {
      S s = L(i, j);
      for (int k = 0; k < j; ++k) s -= L(i, k) * L(j, k);
      L(i, j) = s / pivot;
    }
  }
  return true;
}

/// The same in another matrix, with zeros above the diagonal.
template <class S, int N>
bool cholesky_lower(const Mat<S, N, N>& A, Mat<S, N, N>* L) {
  L->setZero();
  for (int j = 0; j < N; ++j) {
    for (int i = j; i < N; ++i) (*L)(i, j) = A(i, j);
  }
  return cholesky_in_place<S, N>(L);
}

}  // namespace SEGCAL_NS
