// The one QR kernel: fold blocks of rows into an upper triangle by Householder reflections.
//
// A triangle R (n columns, the last ones may be right-hand sides) stands for the stacked rows seen so far:
// R'R = A'A. Folding a block B of m rows replaces [R; B] by Q'[R; B] = [R+; 0]. Each reflection acts on one row of R
// and on the m rows of B, so the cost is 2 m per entry, and columns left of the block's first non-zero one are not touched.
//
// Both passes over the rows are "y += a x" along a row. They run in strips of columns whose sums stay in registers, as
// vectors of 16 or 32 bytes that every target has or splits up (SEGCAL_SCALAR_KERNELS: plain numbers instead). Each column
// has its own sum, in the order of the rows: every build gives the same bits.
#pragma once

#include "math/elementary.h"
#include "math/types.h"

namespace SEGCAL_NS {

/// Rows of a packed upper triangle: row j holds columns j..n-1.
constexpr int packed_size(int n) { return n * (n + 1) / 2; }

/// A packed upper triangle in memory that the caller owns.
template <class S>
class PackedTriangle {
 public:
  PackedTriangle(S* data, int columns) : data_(data), columns_(columns) {}

  int columns() const { return columns_; }
  /// Pointer p such that p[c] is entry (j, c), valid for c >= j.
  S* row(int j) { return data_ + offset(j); }
  const S* row(int j) const { return data_ + offset(j); }
  S operator()(int j, int c) const { return row(j)[c]; }
  void clear() {
    for (int i = 0; i < packed_size(columns_); ++i) data_[i] = S(0);
  }

 private:
  // Row j starts at j n - j (j - 1) / 2 and its first entry is column j.
  int offset(int j) const { return j * columns_ - j * (j - 1) / 2 - j; }
  S* data_;
  int columns_;
};

/// y[c] += a x[c] for c in [first, last).
template <class S>
inline void add_scaled(S* __restrict y, S a, const S* __restrict x, int first, int last) {
  for (int c = first; c < last; ++c) y[c] += a * x[c];
}

/// Squared lengths below this are zero: their inverse would leave the range of the type.
template <class S>
constexpr S smallest_square = std::is_same_v<S, float> ? S(1e-30) : S(1e-200);

/// Columns [first, last) that are known to be zero in every row of a fold, and so are not worked on.
struct ColumnGap {
  int first = 0, last = 0;
};

// Vector registers, or strips of single numbers. Without such registers the compiler's vector type would live in memory.
#if !defined(SEGCAL_SCALAR_KERNELS) && !defined(__SSE2__) && !defined(__ARM_NEON) && \
    !(defined(__ARM_FEATURE_MVE) && (__ARM_FEATURE_MVE & 2))
#define SEGCAL_SCALAR_KERNELS
#endif

/// Vectors of 16 bytes, or 32 where the compiler may use AVX: a type of the compiler, so that the strips below are not left to
/// its guesses.
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

/// Sum of squares of m numbers `stride` apart, in four sums that do not wait for each other.
template <class S>
inline S square_sum(const S* x, int m, int stride) {
  S sum[4] = {S(0), S(0), S(0), S(0)};
  int i = 0;
  for (; i + 4 <= m; i += 4, x += 4 * stride) {
    for (int k = 0; k < 4; ++k) sum[k] += x[k * stride] * x[k * stride];
  }
  for (int k = 0; i < m; ++i, ++k) sum[k] += x[k * stride] * x[k * stride];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// One Householder reflection: clears column j of the m rows of `block` (`stride` apart) against row r, and applies
/// itself to columns (j, n) of all of them. Column j of the block is left as it was: nobody reads it again.
template <class S>
inline void reflect_column(S* r, S* block, int m, int stride, int j, int n, ColumnGap gap = {}) {
  const S below = square_sum(block + j, m, stride);
  if (below < smallest_square<S>) return;  // nothing to clear; the inverse below would overflow
  const S norm = square_root(r[j] * r[j] + below);
  const S alpha = r[j] > S(0) ? -norm : norm;
  const S v0 = r[j] - alpha;             // no cancellation: alpha has the other sign
  const Reflection<S> h{r, block, m, stride, j, v0, S(-1) / (alpha * v0)};  // v'v = -2 alpha v0
  if (gap.last <= j) {
    reflect_range(h, j + 1, n);
  } else {
    reflect_range(h, j + 1, gap.first);
    reflect_range(h, gap.last, n);
  }
  r[j] = alpha;
}

/// Folds the rows of `block` (m rows, row-major, `stride` apart) into R.
/// Columns before `first` of the block are zero; columns [first, pivots) are eliminated (pivots < n leaves rows whose
/// columns [pivots, n) hold what remains). `gap`: columns that are zero in R and in the block, so far.
/// The block is destroyed.
template <class S>
void fold_rows(PackedTriangle<S>& R, S* block, int m, int stride, int first, int pivots, ColumnGap gap = {}) {
  for (int j = first; j < pivots; ++j) {
    if (j == gap.first && gap.last > j) j = gap.last;
    if (j < pivots) reflect_column(R.row(j), block, m, stride, j, R.columns(), gap);
  }
}

/// Clears the `columns` leading columns of a dense block in place (m rows of width n, row-major). Afterwards rows
/// [0, columns) hold the triangle of those columns, and rows [columns, m) are free of them (read from column `columns` on).
/// `gap`: columns that are zero in every row.
template <class S>
void reflect_leading_columns(S* block, int m, int stride, int n, int columns, ColumnGap gap = {}) {
  for (int j = 0; j < columns && j < m; ++j) {
    reflect_column(block + j * stride, block + (j + 1) * stride, m - j - 1, stride, j, n, gap);
  }
}

/// Solves R[0..n, 0..n] x = rhs in place (x overwrites rhs). A pivot that is exactly zero gives x = 0 for that entry.
template <class S>
void back_substitute(const PackedTriangle<S>& R, int n, S* rhs) {
  for (int j = n - 1; j >= 0; --j) {
    const S* r = R.row(j);
    S sum = rhs[j];
    for (int c = j + 1; c < n; ++c) sum -= r[c] * rhs[c];
    rhs[j] = r[j] == S(0) ? S(0) : sum / r[j];
  }
}

/// Lower Cholesky factor of a small symmetric positive matrix, in its place: what is above the diagonal stays as it was.
/// False if a pivot is not positive.
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
