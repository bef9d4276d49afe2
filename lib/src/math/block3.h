// Sums of products of 3 x 3 blocks, in place in larger matrices. Eigen's expressions of them are inlined again at each
// place and leave their temporaries on the stack; these are calls of one small function.
#pragma once

#include "math/types.h"

namespace SEGCAL_NS {

/// A 3 x 3 block: entry (r, c) is p[row r + column c].
template <class S>
struct Block3 {
  S* p;
  int row, column;

  Block3(S* data, int row_step, int column_step) : p(data), row(row_step), column(column_step) {}
  Block3(Mat3<S>& M) : Block3(M.data(), 1, 3) {}
  Block3(const Mat3<S>& M) : Block3(const_cast<S*>(M.data()), 1, 3) {}  // an operand: it is not written to
  Block3 transpose() const { return {p, column, row}; }

  /// this += A B. The blocks must not overlap.
  void add_product(const Block3& A, const Block3& B) const;
  /// this += s A; A may be the transpose of this one's other half, not of itself.
  void add_scaled(S s, const Block3& A) const;
  /// this <- A this
  void multiply_left(const Mat3<S>& A) const;
};

template <class S>
void Block3<S>::add_product(const Block3& A, const Block3& B) const {
  const S *b0 = B.p, *b1 = b0 + B.row, *b2 = b1 + B.row;
  const S b00 = b0[0], b10 = b1[0], b20 = b2[0];
  const S b01 = b0[B.column], b11 = b1[B.column], b21 = b2[B.column];
  const S b02 = b0[2 * B.column], b12 = b1[2 * B.column], b22 = b2[2 * B.column];
  const S* a = A.p;
  S* out = p;
  for (int r = 0; r < 3; ++r, a += A.row, out += row) {
    const S a0 = a[0], a1 = a[A.column], a2 = a[2 * A.column];
    out[0] += a0 * b00 + a1 * b10 + a2 * b20;
    out[column] += a0 * b01 + a1 * b11 + a2 * b21;
    out[2 * column] += a0 * b02 + a1 * b12 + a2 * b22;
  }
}

template <class S>
void Block3<S>::add_scaled(S s, const Block3& A) const {
  const S* a = A.p;
  S* out = p;
  for (int c = 0; c < 3; ++c, a += A.column, out += column) {
    out[0] += s * a[0];
    out[row] += s * a[A.row];
    out[2 * row] += s * a[2 * A.row];
  }
}

template <class S>
void Block3<S>::multiply_left(const Mat3<S>& A) const {
  S* x = p;
  for (int c = 0; c < 3; ++c, x += column) {
    const S x0 = x[0], x1 = x[row], x2 = x[2 * row];
    for (int r = 0; r < 3; ++r) x[row * r] = A.data()[r] * x0 + A.data()[3 + r] * x1 + A.data()[6 + r] * x2;
  }
}

/// A B
template <class S>
Mat3<S> product(const Mat3<S>& A, const Mat3<S>& B) {
  Mat3<S> out = B;
  Block3<S>(out).multiply_left(A);
  return out;
}

}  // namespace SEGCAL_NS
