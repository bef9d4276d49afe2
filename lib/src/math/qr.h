// The one QR kernel: fold blocks of rows into an upper triangle by Householder reflections.
//
// A triangle R (n columns, the last ones may be right-hand sides) stands for the stacked rows seen so far:
// R'R = A'A. Folding a block B of m rows replaces [R; B] by Q'[R; B] = [R+; 0]. Each reflection acts on one row of R
// and on the m rows of B, so the cost is 2 m per entry, and columns left of the block's first non-zero one are not touched.
//
// Both passes over a row are "y += a x" with y and x contiguous: they vectorise without changing the order of any sum,
// so every build gives the same bits.
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

/// One Householder reflection: clears column j of the m rows of `block` (`stride` apart) against row r, and applies
/// itself to columns (j, n) of all of them. Column j of the block is left as it was: nobody reads it again.
template <class S>
inline void reflect_column(S* r, S* block, int m, int stride, int j, int n, S* work, ColumnGap gap = {}) {
  S below = S(0);
  for (int i = 0; i < m; ++i) below += block[i * stride + j] * block[i * stride + j];
  if (below < smallest_square<S>) return;  // nothing to clear; the inverse below would overflow
  const S norm = square_root(r[j] * r[j] + below);
  const S alpha = r[j] > S(0) ? -norm : norm;
  const S v0 = r[j] - alpha;             // no cancellation: alpha has the other sign
  const S scale = S(-1) / (alpha * v0);  // 2 / v'v, since v'v = -2 alpha v0
  const int ranges[2][2] = {{j + 1, gap.first > j ? gap.first : j + 1}, {gap.last > j ? gap.last : j + 1, n}};
  for (const int(&range)[2] : ranges) {
    const int first = range[0], last = range[1];
    if (first >= last) continue;
    for (int c = first; c < last; ++c) work[c] = v0 * r[c];
    for (int i = 0; i < m; ++i) {
      const S b = block[i * stride + j];
      if (b != S(0)) add_scaled(work, b, block + i * stride, first, last);
    }
    for (int c = first; c < last; ++c) work[c] *= scale;
    add_scaled(r, -v0, work, first, last);
    for (int i = 0; i < m; ++i) {
      const S b = block[i * stride + j];
      if (b != S(0)) add_scaled(block + i * stride, -b, work, first, last);
    }
  }
  r[j] = alpha;
}

/// Folds the rows of `block` (m rows, row-major, `stride` apart) into R.
/// Columns before `first` of the block are zero; columns [first, pivots) are eliminated (pivots < n leaves rows whose
/// columns [pivots, n) hold what remains). `gap`: columns that are zero in R and in the block, so far. `work` holds n
/// entries. The block is destroyed.
template <class S>
void fold_rows(PackedTriangle<S>& R, S* block, int m, int stride, int first, int pivots, S* work, ColumnGap gap = {}) {
  for (int j = first; j < pivots; ++j) {
    if (j == gap.first && gap.last > j) j = gap.last;
    if (j < pivots) reflect_column(R.row(j), block, m, stride, j, R.columns(), work, gap);
  }
}

/// Clears the `columns` leading columns of a dense block in place (m rows of width n, row-major). Afterwards rows
/// [0, columns) hold the triangle of those columns, and rows [columns, m) are free of them (read from column `columns` on).
template <class S>
void reflect_leading_columns(S* block, int m, int stride, int n, int columns, S* work) {
  for (int j = 0; j < columns && j < m; ++j) {
    reflect_column(block + j * stride, block + (j + 1) * stride, m - j - 1, stride, j, n, work);
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

/// Lower Cholesky factor of a small symmetric positive matrix; false if a pivot is not positive.
template <class S, int N>
bool cholesky_lower(const Mat<S, N, N>& A, Mat<S, N, N>* L) {
  L->setZero();
  for (int j = 0; j < N; ++j) {
    S d = A(j, j);
    for (int k = 0; k < j; ++k) d -= (*L)(j, k) * (*L)(j, k);
    if (!(d > S(0))) return false;
    const S pivot = square_root(d);
    (*L)(j, j) = pivot;
    for (int i = j + 1; i < N; ++i) {
      S s = A(i, j);
      for (int k = 0; k < j; ++k) s -= (*L)(i, k) * (*L)(j, k);
      (*L)(i, j) = s / pivot;
    }
  }
  return true;
}

}  // namespace SEGCAL_NS
