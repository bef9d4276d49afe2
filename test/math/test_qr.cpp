// The QR kernel against Eigen's, in pieces, with zero columns, tiny entries, and the same bits at each run.
#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cstring>
#include <vector>

#include "../support/cases.h"
#include "../support/random.h"
#include "math/qr.h"
#include "math/small_solvers.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using MatrixXd = Eigen::MatrixXd;

/// A triangle with its own memory.
template <class S>
struct OwnedTriangle {
  std::vector<S> data, work;
  int n;
  explicit OwnedTriangle(int columns) : data(packed_size(columns), S(0)), work(columns), n(columns) {}
  PackedTriangle<S> view() { return PackedTriangle<S>(data.data(), n); }

  void fold(const MatrixXd& rows, int first = 0) { fold_up_to(rows, first, n); }
  std::vector<S> fold_up_to(const MatrixXd& rows, int first, int pivots, ColumnGap gap = {}) {
    std::vector<S> block(rows.size());
    for (int i = 0; i < rows.rows(); ++i) {
      for (int j = 0; j < n; ++j) block[i * n + j] = static_cast<S>(rows(i, j));
    }
    PackedTriangle<S> R = view();
    fold_rows(R, block.data(), static_cast<int>(rows.rows()), n, first, pivots, gap);
    return block;
  }
  MatrixXd dense() {
    MatrixXd R = MatrixXd::Zero(n, n);
    for (int i = 0; i < n; ++i) {
      for (int j = i; j < n; ++j) R(i, j) = view()(i, j);
    }
    return R;
  }
};

template <class S>
double rounding() {
  return std::numeric_limits<S>::epsilon();
}

/// Distance of two Gram matrices relative to their size.
double gram_distance(const MatrixXd& A, const MatrixXd& B) {
  const MatrixXd a = A.transpose() * A, b = B.transpose() * B;
  return (a - b).norm() / b.norm();
}

template <class S>
void check_against_eigen() {
  test::Random random(21);
  const int sizes[][2] = {{1, 1}, {2, 5}, {5, 5}, {40, 7}, {120, 31}, {300, 60}};
  for (const auto& size : sizes) {
    const MatrixXd A = random.matrix(size[0], size[1]).cast<S>().template cast<double>();
    OwnedTriangle<S> R(size[1]);
    R.fold(A);
    const MatrixXd reference = Eigen::HouseholderQR<MatrixXd>(A)
                                   .matrixQR()
                                   .topRows(std::min(size[0], size[1]))
                                   .template triangularView<Eigen::Upper>();
    // Backward error of Householder QR: a small multiple of epsilon times the square root of the number of reflections.
    const Id id = Id().add("check", "eigen").type<S>().add("rows", size[0]).add("columns", size[1]);
    test::check_near(id, "R'R", 0, gram_distance(R.dense(), reference), 10 * rounding<S>() * std::sqrt(size[1]));
  }
}

template <class S>
void check_pieces() {
  // Folding row block after row block stands for the same stacked rows as folding them at once.
  test::Random random(22);
  const int n = 24;
  const MatrixXd A = random.matrix(90, n).cast<S>().template cast<double>();
  OwnedTriangle<S> whole(n);
  whole.fold(A);
  for (int piece : {1, 2, 7, 45, 89}) {
    OwnedTriangle<S> streamed(n);
    for (int row = 0; row < A.rows(); row += piece)
      streamed.fold(A.middleRows(row, std::min<int>(piece, A.rows() - row)));
    test::check_near(Id().add("check", "pieces").type<S>().add("piece", piece), "R'R", 0,
                     gram_distance(streamed.dense(), whole.dense()), 40 * rounding<S>());
  }
}

template <class S>
void check_leading_zeros() {
  // A block whose first columns are zero gives the same triangle whether they are skipped or not.
  test::Random random(23);
  const int n = 15;
  for (int first : {1, 6, 14}) {
    MatrixXd A = random.matrix(8, n), B = random.matrix(12, n);
    A.leftCols(first).setZero();
    OwnedTriangle<S> skipped(n), full(n);
    skipped.fold(B);
    full.fold(B);
    skipped.fold(A, first);
    full.fold(A, 0);
    const Id id = Id().add("check", "leading_zeros").type<S>().add("first", first);
    test::check_true(id, "the bits differ", skipped.data == full.data);
  }
}

template <class S>
void check_gap() {
  // Columns that are zero in the triangle and in the block may be passed over: the same bits, and they stay zero.
  test::Random random(30);
  const int n = 20;
  const ColumnGap gap = {6, 13};
  OwnedTriangle<S> passed(n), worked(n);
  for (int rows : {9, 15, 4}) {
    MatrixXd A = random.matrix(rows, n);
    A.middleCols(gap.first, gap.last - gap.first).setZero();
    worked.fold(A);
    passed.fold_up_to(A, 0, n, gap);
  }
  const Id id = Id().add("check", "gap").type<S>();
  test::check_true(id, "the bits differ", passed.data == worked.data);
  test::check_true(id, "the gap was written to", passed.dense().middleCols(gap.first, gap.last - gap.first).isZero(0));
}

template <class S>
void check_strips() {
  // A column depends on itself and on those before it: however the kernel cuts the columns into strips, a triangle of
  // the first n columns has the bits of the wide one, and nothing beside the block is written to.
  test::Random random(31);
  const int m = 7, widest = 61;
  const MatrixXd A = random.matrix(m, widest);
  OwnedTriangle<S> wide(widest);
  wide.fold(A);
  wide.fold(A * 0.5);
  for (int n = 1; n < widest; ++n) {
    OwnedTriangle<S> R(n);
    for (double factor : {1.0, 0.5}) {
      std::vector<S> block(m * n + 2 * n, S(5));
      for (int i = 0; i < m; ++i) {
        for (int c = 0; c < n; ++c) block[(i + 1) * n + c] = static_cast<S>(factor * A(i, c));
      }
      PackedTriangle<S> view = R.view();
      fold_rows(view, block.data() + n, m, n, 0, n);
      bool untouched = true;
      for (int c = 0; c < n; ++c) untouched = untouched && block[c] == S(5) && block[(m + 1) * n + c] == S(5);
      test::check_true(Id().add("check", "strips").type<S>().add("columns", n), "written beside the block", untouched);
    }
    const bool same = (R.dense().array() == wide.dense().topLeftCorner(n, n).array()).all();
    test::check_true(Id().add("check", "strips").type<S>().add("columns", n), "the bits differ", same);
  }
}

template <class S>
void check_remaining_rows() {
  // With fewer pivots than columns the block keeps what remains: the Schur complement of the eliminated columns.
  test::Random random(24);
  const int n = 9, pivots = 4;
  const MatrixXd A = random.matrix(20, n);
  OwnedTriangle<S> R(n);
  const std::vector<S> rest = R.fold_up_to(A, 0, pivots);
  MatrixXd right(20, n - pivots);
  for (int i = 0; i < 20; ++i) {
    for (int c = pivots; c < n; ++c) right(i, c - pivots) = rest[i * n + c];
  }
  const MatrixXd left = A.leftCols(pivots), other = A.rightCols(n - pivots);
  const MatrixXd schur = other.transpose() * other -
                         other.transpose() * left * (left.transpose() * left).ldlt().solve(left.transpose() * other);
  test::check_near(Id().add("check", "remaining").type<S>(), "Schur complement", 0,
                   (right.transpose() * right - schur).norm() / schur.norm(), 40 * rounding<S>());
}

template <class S>
void check_leading_columns() {
  test::Random random(25);
  const int m = 11, n = 8, columns = 3;
  const MatrixXd A = random.matrix(m, n).cast<S>().template cast<double>();
  std::vector<S> block(m * n), work(n);
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j < n; ++j) block[i * n + j] = static_cast<S>(A(i, j));
  }
  reflect_leading_columns(block.data(), m, n, n, columns);
  // The rows left carry what the first three columns cannot explain.
  const MatrixXd left = A.leftCols(columns), other = A.rightCols(n - columns);
  const MatrixXd expected = other - left * left.householderQr().solve(other);
  MatrixXd rest(m - columns, n - columns);
  for (int i = columns; i < m; ++i) {
    for (int j = columns; j < n; ++j) rest(i - columns, j - columns) = block[i * n + j];
  }
  test::check_near(Id().add("check", "leading_columns").type<S>(), "null space", 0, gram_distance(rest, expected),
                   20 * rounding<S>());
}

template <class S>
void check_tiny_rows() {
  test::Random random(26);
  const int n = 6;
  // From ordinary numbers through values whose squares underflow down to denormals, and exact zeros.
  for (double size : {1.0, 1e-10, 1e-16, 1e-19, 1e-22, 1e-30, 1e-38, 1e-44, 0.0}) {
    OwnedTriangle<S> R(n);
    R.fold(size * random.matrix(10, n));
    R.fold(random.matrix(10, n));
    R.fold(size * random.matrix(3, n));
    const MatrixXd dense = R.dense();
    test::check_true(Id().add("check", "tiny").type<S>().add("size", size), "not finite", dense.allFinite());
    // Ten ordinary rows are there: every pivot is of order one.
    test::check_between(Id().add("check", "tiny_pivots").type<S>().add("size", size), "pivot", 1e-3,
                        dense.diagonal().cwiseAbs().minCoeff(), 1e3);
  }
}

template <class S>
void check_same_bits() {
  test::Random random(27);
  const MatrixXd A = random.matrix(50, 20);
  OwnedTriangle<S> first(20);
  first.fold(A);
  for (int run = 0; run < 3; ++run) {
    OwnedTriangle<S> again(20);
    again.fold(A);
    const bool same = std::memcmp(first.data.data(), again.data.data(), first.data.size() * sizeof(S)) == 0;
    test::check_true(Id().add("check", "bits").type<S>().add("run", run), "the bits differ", same);
  }
}

template <class S>
void check_least_squares() {
  test::Random random(28);
  const int n = 12;
  const MatrixXd A = random.matrix(60, n + 1).cast<S>().template cast<double>();
  OwnedTriangle<S> R(n + 1);
  R.fold(A);
  std::vector<S> x(n);
  for (int i = 0; i < n; ++i) x[i] = R.view()(i, n);
  back_substitute(R.view(), n, x.data());
  const Eigen::VectorXd expected = A.leftCols(n).householderQr().solve(A.col(n));
  const double rho = (A.leftCols(n) * expected - A.col(n)).norm();
  const Id id = Id().add("check", "least_squares").type<S>();
  // The condition number of 60 x 12 normal numbers is below 5.
  for (int i = 0; i < n; ++i) test::check_near(id.add("column", i), "x", expected(i), x[i], 50 * rounding<S>());
  test::check_near(id, "rho", rho, std::fabs(double(R.view()(n, n))), 50 * rounding<S>() * rho);
}

template <class S>
void check_zero_pivot() {
  OwnedTriangle<S> R(3);
  MatrixXd A(2, 3);
  A << 2, 0, 4, 0, 0, 0;
  R.fold(A);
  S x[2] = {R.view()(0, 2), R.view()(1, 2)};
  back_substitute(R.view(), 2, x);
  const Id id = Id().add("check", "zero_pivot").type<S>();
  test::check_near(id, "x0", 2, x[0], 1e-6);
  test::check_near(id, "x1 stays where it was", 0, x[1], 0);
}

template <class S>
void check_cholesky() {
  test::Random random(29);
  const MatrixXd B = random.matrix(20, 6);
  const Mat<S, 6, 6> A = (B.transpose() * B).cast<S>();
  Mat<S, 6, 6> L;
  const Id id = Id().add("check", "cholesky").type<S>();
  test::check_true(id, "refused a positive matrix", cholesky_lower<S, 6>(A, &L));
  test::check_near(id, "L L'", 0, double((L * L.transpose() - A).norm() / A.norm()), 10 * rounding<S>());
  Mat<S, 6, 6> indefinite = A;
  indefinite(3, 3) = S(-1);
  test::check_true(id, "accepted an indefinite matrix", !cholesky_lower<S, 6>(indefinite, &L));
}

template <class S>
void check_all() {
  check_against_eigen<S>();
  check_pieces<S>();
  check_leading_zeros<S>();
  check_gap<S>();
  check_strips<S>();
  check_remaining_rows<S>();
  check_leading_columns<S>();
  check_tiny_rows<S>();
  check_same_bits<S>();
  check_least_squares<S>();
  check_zero_pivot<S>();
  check_cholesky<S>();
}

void test_qr_in_float() { check_all<float>(); }
void test_qr_in_double() { check_all<double>(); }

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_qr_in_float);
  RUN_TEST(test_qr_in_double);
  return UNITY_END();
}
