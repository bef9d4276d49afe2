// The evidence for an effect, by the densities that it is the ratio of.
#include <Eigen/Cholesky>
#include <cmath>

#include "../support/cases.h"
#include "diagnose/rivals.h"
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

/// An effect that is called and holds in both halves, and a step that is as significant as any: the step gives way
/// where evidence and share make it less likely, by natural logarithms.
void test_a_step_gives_way_to_what_is_likelier() {
  test::LinearRecording recording;
  recording.add("effect", 1, 0.5, 0.3);
  test::Random random(4);
  const Problem problem = problem_of(recording, &random);
  Shift step;
  step.trials = 30;
  step.test.log10_p = -1000;
  const std::vector<std::pair<double, int>> called = {{-10, 0}};
  const Candidate& effect = recording.candidates[0];
  const double as_likely =
      test_effect(problem, effect, {}).log_evidence + std::log(effect.share) - std::log(decision::kStepsShare / 30);
  for (const double beside : {-0.01, 0.01}) {
    step.test.log_evidence = as_likely + beside;
    TEST_ASSERT_EQUAL(beside < 0, says_more_than(step, called, problem, recording.candidates, {}));
  }
  recording.truth.setConstant(-0.3);  // half of the segments contradict the others
  Problem torn = problem;
  torn.held_out = problem_of(recording, &random).held_out;
  step.test.log_evidence = -1e3;
  TEST_ASSERT_FALSE(says_more_than(step, called, torn, recording.candidates, {}));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_evidence_is_the_ratio_of_two_densities);
  RUN_TEST(test_a_step_gives_way_to_what_is_likelier);
  return UNITY_END();
}
