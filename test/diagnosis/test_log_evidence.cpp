// The evidence for an effect, by the densities that it is the ratio of.
#include <Eigen/Cholesky>
#include <cmath>

#include "../support/cases.h"
#include "linear_problem.h"

using namespace host::diagnosis;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// log N(d; 0, C) but for the constant.
double log_density(const Eigen::VectorXd& d, const Eigen::MatrixXd& C) {
  const Eigen::LLT<Eigen::MatrixXd> llt(C);
  const Eigen::MatrixXd L = llt.matrixL();
  return -0.5 * d.dot(llt.solve(d)) - L.diagonal().array().log().sum();
}

/// What the rows say beside theta is d = R c + e, e ~ N(0, noise 1): with c ~ N(0, size^2) of variance noise + R size^2
/// R'. Of three directions one is seen 18 times better than it is large, two hardly.
void test_evidence_is_the_ratio_of_two_densities() {
  for (const int seed : {1, 2, 3}) {
    test::LinearRecording recording;
    recording.add("other", 1, 1);
    recording.add("effect", 3, 0.5, 0.3);
    recording.shape = [&recording](Eigen::MatrixXd* J) { J->rightCols(2) *= 0.03; };
    test::Random random(seed);
    const Problem problem = problem_of(recording, &random);
    const Candidate& effect = recording.candidates[1];
    const EffectTest test = test_effect(problem, effect, {});
    TEST_ASSERT_EQUAL_INT(1, test.seen);
    const Marginal m =
        marginal_of(with_groups(with_prior(problem.all, problem.prior), problem.n_theta, {effect.columns}), 3);
    const double noise = dispersion(problem, {});
    const Eigen::MatrixXd without = noise * Eigen::MatrixXd::Identity(3, 3),
                          with = without + 0.25 * m.R * m.R.transpose();
    const double expected = log_density(m.d, with) - log_density(m.d, without);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * std::abs(expected), expected, test.log_evidence);  // rounding
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_evidence_is_the_ratio_of_two_densities);
  return UNITY_END();
}
