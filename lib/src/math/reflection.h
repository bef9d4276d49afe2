// A Householder reflection of one row against a block of rows, in strips of columns.
//
// Both passes over the rows are "y += a x" along a row. They run in strips of columns whose sums stay in registers, as
// vectors of 16 or 32 bytes that every target has or splits up (SEGCAL_SCALAR_KERNELS: plain numbers instead). Each
// column has its own sum, in the order of the rows: every build gives the same bits.
#pragma once

#include "math/types.h"

namespace SEGCAL_NS {

// Vector registers, or strips of single numbers. Without such
// registers the compiler's vector type would live in memory.
#if !defined(SEGCAL_SCALAR_KERNELS) && !defined(__SSE2__) && !defined(__ARM_NEON) && \
    !(defined(__ARM_FEATURE_MVE) && (__ARM_FEATURE_MVE & 2))
#define SEGCAL_SCALAR_KERNELS
#endif

/// Vectors of 16 bytes, or 32 where the compiler may use AVX: a type of
/// the compiler, so that the strips below are not left to its guesses.
template <class S>
struct Lanes {
#ifdef __AVX__
  static constexpr int kBytes = 32;
#else
  static constexpr int kBytes = 16;
#endif
  static constexpr int kCount = kBytes / static_cast<int>(sizeof(S));
#ifndef SEGCAL_SCALAR_KERNELS
  typedef S Vector __attribute__((vector_size(kBytes)));
  static Vector load(const S* p) {
    Vector v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
  }
  static void store(S* p, const Vector& v) { __builtin_memcpy(p, &v, sizeof v); }
#endif
};

/// A Householder reflection I - v v' / (alpha v0) of a row r and m rows of a block: v = (v0, column j of the block).
template <class S>
struct Reflection {
  S* r;
  S* block;
  int m, stride, j;
  S v0, scale;  ///< scale = -1 / (alpha v0), which is 2 / v'v

  const S* column() const { return block + j; }
};

#ifndef SEGCAL_SCALAR_KERNELS
/// Applies it to N vectors of columns from c on, but for the first `done` columns: those stay as they are.
template <int N, class S>
inline void reflect_strip(const Reflection<S>& h, int c, int done = 0) {
  using L = Lanes<S>;
  const S v0 = h.v0;
  const int stride = h.stride, column = h.j - c;  // of the reflection's vector, as seen from column c
  S *const r = h.r + c, *const first = h.block + c, *const last = first + h.m * stride;
  typename L::Vector w[N];
  for (int k = 0; k < N; ++k) w[k] = v0 * L::load(r + k * L::kCount);
  for (const S* x = first; x != last; x += stride) {
    const S v = x[column];
    for (int k = 0; k < N; ++k) w[k] += v * L::load(x + k * L::kCount);
  }
  for (int k = 0; k < N; ++k) w[k] *= h.scale;
  for (int l = 0; l < done; ++l) w[0][l] = S(0);
  for (int k = 0; k < N; ++k) L::store(r + k * L::kCount, L::load(r + k * L::kCount) - v0 * w[k]);
  for (S* x = first; x != last; x += stride) {
    const S v = x[column];
    for (int k = 0; k < N; ++k) L::store(x + k * L::kCount, L::load(x + k * L::kCount) - v * w[k]);
  }
}
#else
/// Applies it to W columns from c on, with W sums in registers, but for the first `done` columns.
template <int W, class S>
inline void reflect_columns(const Reflection<S>& h, int c, int done) {
  const S v0 = h.v0;
  const int stride = h.stride, column = h.j - c;
  S *const r = h.r + c, *const first = h.block + c, *const last = first + h.m * stride;
  S w[W];
#pragma GCC unroll 16
  for (int k = 0; k < W; ++k) w[k] = v0 * r[k];
  for (const S* x = first; x != last; x += stride) {
    const S v = x[column];
#pragma GCC unroll 16
    for (int k = 0; k < W; ++k) w[k] += v * x[k];
  }
#pragma GCC unroll 16
  for (int k = 0; k < W; ++k) w[k] = k < done ? S(0) : w[k] * h.scale;
#pragma GCC unroll 16
  for (int k = 0; k < W; ++k) r[k] -= v0 * w[k];
  for (S* x = first; x != last; x += stride) {
    const S v = x[column];
#pragma GCC unroll 16
    for (int k = 0; k < W; ++k) x[k] -= v * w[k];
  }
}

/// The same for N times the columns of a vector.
template <int N, class S>
inline void reflect_strip(const Reflection<S>& h, int c, int done = 0) {
  constexpr int kVector = Lanes<S>::kCount, kWide = 3 * kVector;
  int k = 0;
  for (; k + kWide <= N * kVector; k += kWide) reflect_columns<kWide>(h, c + k, k == 0 ? done : 0);
  for (; k < N * kVector; k += kVector) reflect_columns<kVector>(h, c + k, k == 0 ? done : 0);
}
#endif

/// The same for one column: where fewer columns are left than a vector has.
template <class S>
inline void reflect_single(const Reflection<S>& h, int c) {
  const S* b = h.column();
  S* x = h.block + c;
  S w = h.v0 * h.r[c];
  for (int i = 0; i < h.m; ++i) w += b[i * h.stride] * x[i * h.stride];
  w *= h.scale;
  h.r[c] -= h.v0 * w;
  for (int i = 0; i < h.m; ++i) x[i * h.stride] -= b[i * h.stride] * w;
}

/// N vectors, N known only now.
template <class S>
inline void reflect_vectors(const Reflection<S>& h, int c, int vectors, int done) {
  switch (vectors) {
    case 1: return reflect_strip<1>(h, c, done);
    case 2: return reflect_strip<2>(h, c, done);
    case 3: return reflect_strip<3>(h, c, done);
    case 4: return reflect_strip<4>(h, c, done);
    case 5: return reflect_strip<5>(h, c, done);
    default: return reflect_strip<6>(h, c, done);
  }
}

/// Applies it to columns [first, last). Where the last strip is no whole number of vectors, it ends at `last` all the
/// same, and its first columns, which the strip before has done, stay as they are.
template <class S>
inline void reflect_range(const Reflection<S>& h, int first, int last) {
  constexpr int kVector = Lanes<S>::kCount, kStrip = 6 * kVector;
  int c = first;
  for (; c + kStrip <= last; c += kStrip) reflect_strip<6>(h, c);
  int vectors = (last - c + kVector - 1) / kVector;
  if (vectors <= 0) return;
  if (last - vectors * kVector < first) {
    for (; c < first + (last - first) % kVector; ++c) reflect_single(h, c);
    if (--vectors == 0) return;
  }
  reflect_vectors(h, last - vectors * kVector, vectors, c - (last - vectors * kVector));
}

}  // namespace SEGCAL_NS
