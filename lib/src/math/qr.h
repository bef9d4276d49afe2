// The one QR kernel: fold blocks of rows into an upper triangle by Householder reflections.
//
// A triangle R (n columns, the last ones may be right-hand sides) stands for the stacked rows seen so far:
// R'R = A'A. Folding a block B of m rows replaces [R; B] by Q'[R; B] = [R+; 0].
// Each reflection acts on one row of R and on the m rows of B, so the cost is 2 m
// per entry, and columns left of the block's first non-zero one are not touched.
#pragma once

#include "math/elementary.h"
#include "math/packed_triangle.h"
#include "math/reflection.h"
#include "math/types.h"

namespace SEGCAL_NS {

/// Squared lengths below this are zero: their inverse would leave the range of the type.
template <class S>
constexpr S smallest_square = std::is_same_v<S, float> ? S(1e-30) : S(1e-200);

/// Columns [first, last) that are known to be zero in every row of a fold, and so are not worked on.
struct ColumnGap {
  int first = 0, last = 0;
};

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
  const S v0 = r[j] - alpha;                                                // no cancellation: alpha has the other sign
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
/// [0, columns) hold the triangle of those columns, and rows [columns, m) are free of them (read from column `columns`
/// on). `gap`: columns that are zero in every row.
template <class S>
void reflect_leading_columns(S* block, int m, int stride, int n, int columns, ColumnGap gap = {}) {
  for (int j = 0; j < columns && j < m; ++j) {
    reflect_column(block + j * stride, block + (j + 1) * stride, m - j - 1, stride, j, n, gap);
  }
}

}  // namespace SEGCAL_NS
