// The score test against ordinary least squares: what the cost
// falls by, estimates and covariances, in float and double.
#include <Eigen/LU>
#include <Eigen/QR>
#include <vector>

#include "../support/cases.h"
#include "../support/random.h"
#include "diagnosis/score_test.h"

using namespace SEGCAL_NS;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kTheta = 5, kRows = 200;
const TermGroup kGroups[] = {{0, 1}, {1, 3}, {4, 2}, {6, 9}};
constexpr int kTerms = 15;

/// Rows [theta | terms | rhs] with noise of unit variance and columns of very different units.
MatrixXd rows_with(test::Random* random, const VectorXd& truth) {
  MatrixXd A = random->matrix(kRows, kTheta + kTerms + 1);
  for (int c = 0; c < kTheta; ++c) A.col(kTheta + c) += 2 * A.col(c);  // terms that theta can explain in part
  for (int c = 0; c < kTheta + kTerms; ++c) A.col(c) *= std::pow(10.0, c % 5 - 2);
  A.col(kTheta + kTerms) += A.leftCols(kTheta + kTerms) * truth;
  return A;
}

template <class S>
std::vector<S> triangle_of(const MatrixXd& A) {
  const int n = static_cast<int>(A.cols());
  std::vector<S> data(packed_size(n), S(0)), block(A.size());
  for (int i = 0; i < A.rows(); ++i)
    for (int c = 0; c < n; ++c) block[i * n + c] = static_cast<S>(A(i, c));
  PackedTriangle<S> R(data.data(), n);
  fold_rows(R, block.data(), static_cast<int>(A.rows()), n, 0, n);
  return data;
}

/// Least squares over chosen columns; returns the cost.
double fit(const MatrixXd& A, const std::vector<int>& columns, VectorXd* x, MatrixXd* covariance) {
  MatrixXd B(A.rows(), columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) B.col(i) = A.col(columns[i]);
  *x = B.colPivHouseholderQr().solve(A.col(A.cols() - 1));
  *covariance = (B.transpose() * B).inverse();
  return (A.col(A.cols() - 1) - B * *x).squaredNorm();
}

std::vector<int> theta_columns() {
  std::vector<int> out;
  for (int c = 0; c < kTheta; ++c) out.push_back(c);
  return out;
}

void add_group(const TermGroup& g, std::vector<int>* columns) {
  for (int i = 0; i < g.count; ++i) columns->push_back(kTheta + g.first + i);
}

template <class S>
EffectScore<S> score_of(const MatrixXd& A, const TermGroup& effect, const std::vector<TermGroup>& accepted) {
  std::vector<S> data = triangle_of<S>(A), scratch(ScoreTest<S>::scratch_size(kTerms));
  const PackedTriangle<S> R(data.data(), kTheta + kTerms + 1);
  return ScoreTest<S>(R, kTheta, scratch.data()).of(effect, accepted.data(), static_cast<int>(accepted.size()));
}

template <class S>
void check_against_least_squares(const MatrixXd& A, const TermGroup& effect, const std::vector<TermGroup>& accepted,
                                 double relative) {
  std::vector<int> columns = theta_columns();
  for (const TermGroup& g : accepted) add_group(g, &columns);
  VectorXd x;
  MatrixXd covariance;
  const double without = fit(A, columns, &x, &covariance);
  add_group(effect, &columns);
  const double with = fit(A, columns, &x, &covariance);
  const EffectScore<S> score = score_of<S>(A, effect, accepted);
  const int m = effect.count, at = static_cast<int>(columns.size()) - m;
  const double length = A.col(A.cols() - 1).norm();
  TEST_ASSERT_EQUAL_INT(m, score.dof);
  TEST_ASSERT_DOUBLE_WITHIN(relative * without, without - with, score.statistic);
  for (int i = 0; i < m; ++i) {
    const double sigma = std::sqrt(covariance(at + i, at + i));
    TEST_ASSERT_DOUBLE_WITHIN(relative * length * sigma, x(at + i), score.estimate[i]);
    for (int j = 0; j < m; ++j) {
      const double both = sigma * std::sqrt(covariance(at + j, at + j));
      TEST_ASSERT_DOUBLE_WITHIN(100 * relative * both, covariance(at + i, at + j), score.covariance[i * m + j]);
    }
  }
}

// 1e-6: float's rounding (6e-8) over 200 rows; of the cost, and of the residual's length for estimates in units of
// sigma. Covariances of columns that theta explains four fifths of: 100 times that.
void test_agrees_with_least_squares() {
  test::Random random(1);
  VectorXd truth = VectorXd::Zero(kTheta + kTerms);
  truth(kTheta) = 50;
  truth(kTheta + 4) = 0.1;
  const MatrixXd A = rows_with(&random, truth);
  for (const TermGroup& g : kGroups) {
    check_against_least_squares<double>(A, g, {}, 1e-12);
    check_against_least_squares<float>(A, g, {}, 1e-6);
  }
  check_against_least_squares<double>(A, kGroups[1], {kGroups[0]}, 1e-12);
  check_against_least_squares<double>(A, kGroups[3], {kGroups[2], kGroups[0]}, 1e-12);
  check_against_least_squares<float>(A, kGroups[3], {kGroups[2], kGroups[0]}, 1e-6);
}

/// Without an effect s is chi-square: mean dof, variance 2 dof. 400 draws: 4 sigma of the mean is 4 sqrt(2 dof / 400).
void test_null_distribution() {
  test::Random random(2);
  constexpr int kDraws = 400;
  double sum[4] = {}, squares[4] = {};
  for (int k = 0; k < kDraws; ++k) {
    const MatrixXd A = rows_with(&random, VectorXd::Zero(kTheta + kTerms));
    for (int g = 0; g < 4; ++g) {
      const double s = score_of<float>(A, kGroups[g], {}).statistic;
      sum[g] += s;
      squares[g] += s * s;
    }
  }
  for (int g = 0; g < 4; ++g) {
    const double dof = kGroups[g].count, mean = sum[g] / kDraws, variance = squares[g] / kDraws - mean * mean;
    TEST_ASSERT_DOUBLE_WITHIN(4 * std::sqrt(2 * dof / kDraws), dof, mean);
    TEST_ASSERT_DOUBLE_WITHIN(0.4 * 2 * dof + 0.4, 2 * dof,
                              variance);  // 4 sigma of a variance of 400 chi-squares with 1 dof
  }
}

/// A column that is a combination of theta's, and one that is a
/// multiple of an accepted column: no direction, no statistic.
void test_collinear_columns_say_nothing() {
  test::Random random(3);
  VectorXd truth = VectorXd::Zero(kTheta + kTerms);
  truth(kTheta + 4) = 0.5;
  MatrixXd A = rows_with(&random, truth);
  A.col(kTheta + 1) = A.col(0) * 3 - A.col(1);
  A.col(kTheta + 5) = A.col(kTheta) * 7;
  const EffectScore<float> in_theta = score_of<float>(A, kGroups[1], {});
  TEST_ASSERT_EQUAL_INT(2, in_theta.dof);
  TEST_ASSERT_EQUAL_FLOAT(0, in_theta.estimate[0]);
  check_against_least_squares<double>(A, {2, 2}, {}, 1e-12);
  const EffectScore<double> rest = score_of<double>(A, {2, 2}, {}), whole = score_of<double>(A, kGroups[1], {});
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, rest.statistic, whole.statistic);
  TEST_ASSERT_EQUAL_INT(2, score_of<float>(A, kGroups[2], {}).dof);
  TEST_ASSERT_EQUAL_INT(1, score_of<float>(A, kGroups[2], {kGroups[0]}).dof);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_agrees_with_least_squares);
  RUN_TEST(test_null_distribution);
  RUN_TEST(test_collinear_columns_say_nothing);
  return UNITY_END();
}
