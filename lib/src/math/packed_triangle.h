// A packed upper triangle in memory that the caller owns.
#pragma once

#include "math/types.h"

namespace SEGCAL_NS {

/// Rows of a packed upper triangle: row j holds columns j..n-1.
constexpr int packed_size(int n) { return n * (n + 1) / 2; }

/// Of triangles, or parts of them.
template <class S>
void copy_numbers(const S* from, int n, S* to) {
  for (int i = 0; i < n; ++i) to[i] = from[i];
}

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

}  // namespace SEGCAL_NS
