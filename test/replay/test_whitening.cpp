// The Kalman filter of a track's noise against the dense covariance that it stands for.
#include <Eigen/Cholesky>
#include <random>

#include "replay/whitening.h"
#include "unity.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr int kPoints = 20;
constexpr double kRounding = 1e-11;  // of numbers of about 1, over 20 points

Eigen::VectorXd drawn(std::mt19937_64* random, double least, double most) {
  std::uniform_real_distribution<double> u(least, most);
  return Eigen::VectorXd::NullaryExpr(kPoints, [&] { return u(*random); });
}

/// px^2: the walk is the sum of its steps so far.
Eigen::MatrixXd walk_covariance(const Eigen::VectorXd& step) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kPoints, kPoints);
  for (int i = 0; i < kPoints; ++i) sum.bottomRightCorner(kPoints - i, kPoints - i).array() += step(i);
  return sum;
}

struct Case {
  Eigen::VectorXd step, white;
  Eigen::MatrixXd columns;
};

/// The first point has no step; two in the middle come at the same time.
Case a_case(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Case c{drawn(&random, 0.01, 2), drawn(&random, 0.1, 3), Eigen::MatrixXd(kPoints, 3)};
  c.step(0) = c.step(7) = 0;
  for (int i = 0; i < 3; ++i) c.columns.col(i) = drawn(&random, -2, 2);
  return c;
}

void test_whitens() {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Case c = a_case(seed);
    const host::Whitening whiten(c.step, c.white);
    Eigen::MatrixXd C = walk_covariance(c.step);
    C.diagonal() += c.white;
    const Eigen::LLT<Eigen::MatrixXd> llt(C);
    const Eigen::MatrixXd expected = llt.matrixL().solve(c.columns);
    TEST_ASSERT_DOUBLE_WITHIN(kRounding, 0, (whiten(c.columns) - expected).cwiseAbs().maxCoeff());
    TEST_ASSERT_DOUBLE_WITHIN(kRounding, 2 * llt.matrixLLT().diagonal().array().log().sum(), whiten.log_determinant());
  }
}

void test_finds_the_walk() {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Case c = a_case(seed);
    const Eigen::MatrixXd walk = walk_covariance(c.step);
    Eigen::MatrixXd C = walk;
    C.diagonal() += c.white;
    const Eigen::MatrixXd expected = walk * C.llt().solve(c.columns);
    TEST_ASSERT_DOUBLE_WITHIN(kRounding, 0,
                              (host::Whitening(c.step, c.white).walk_in(c.columns) - expected).cwiseAbs().maxCoeff());
  }
}

/// A tracker without any walk.
void test_white_noise_alone() {
  Case c = a_case(1);
  c.step.setZero();
  const host::Whitening whiten(c.step, c.white);
  TEST_ASSERT_DOUBLE_WITHIN(kRounding, 0, whiten.walk_in(c.columns).cwiseAbs().maxCoeff());
  TEST_ASSERT_DOUBLE_WITHIN(kRounding, c.columns(5, 1) / std::sqrt(c.white(5)), whiten(c.columns)(5, 1));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_whitens);
  RUN_TEST(test_finds_the_walk);
  RUN_TEST(test_white_noise_alone);
  return UNITY_END();
}
