// Which effect a search fits first, what it tries where rows are linearised far from its value, and when it ends.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "../support/cases.h"
#include "diagnose/evidence.h"
#include "diagnose/hypotheses.h"
#include "diagnose/rivals.h"
#include "linear_problem.h"
#include "simulate/simulate.h"

using namespace host::diagnosis;
using test::LinearRecording;
using test::names;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

LinearRecording catalogue() {
  LinearRecording r;
  r.add("offset", 1, 1);
  r.add("shutter", 1, 1);
  r.add("lag", 1, 1);
  return r;
}

/// Statistics of 0.6^2 and 0.25^2 times 1440 rows over the dispersion: 5.8 times apart, and with 0.45, 1.8 times.
void test_the_dominant_one() {
  for (int seed = 0; seed < 20; ++seed) {
    LinearRecording recording = catalogue();
    recording.truth(1) = 0.6;
    recording.truth(2) = 0.25;
    test::Random random(2000 + seed);
    const Problem apart = problem_of(recording, &random);
    TEST_ASSERT_EQUAL_INT(1, dominant_of(apart, recording.candidates, {}, {0, 1, 2}));
    // The other one, where the first is not open; and none where nothing is significant.
    TEST_ASSERT_EQUAL_INT(2, dominant_of(apart, recording.candidates, {}, {0, 2}));
    TEST_ASSERT_EQUAL_INT(-1, dominant_of(apart, recording.candidates, {}, {0}));
    recording.truth(2) = 0.45;
    TEST_ASSERT_EQUAL_INT(-1, dominant_of(problem_of(recording, &random), recording.candidates, {}, {0, 1, 2}));
  }
}

/// Far from its value, an effect looks three times as large in one half as in the other, and as if others were there.
/// At its own fit it is the same in both: it alone has a name. If it is not the same there either, nothing has.
void test_what_says_most_is_tried_at_its_own_fit() {
  LinearRecording far = catalogue(), fitted = catalogue();
  fitted.truth(0) = 0.6;
  far.outside = [](int s, const Eigen::MatrixXd& J, Eigen::VectorXd* r) {
    *r += (is_held_out(s) ? 0.9 : 0.3) * J.col(6) + 0.1 * J.col(7);
  };
  for (int seed = 0; seed < 20; ++seed) {
    test::Random random(2100 + seed);
    const Problem first = problem_of(far, &random), second = problem_of(fitted, &random);
    const Selection s = select_effects(
        far.candidates, {}, [&](const std::vector<int>& accepted) { return accepted.empty() ? first : second; });
    TEST_ASSERT_TRUE_MESSAGE(names(s) == std::vector<std::string>{"offset"}, std::to_string(2100 + seed).c_str());
    const Selection never = select_effects(far.candidates, {}, [&](const std::vector<int>&) { return first; });
    TEST_ASSERT_TRUE(names(never).empty() || names(never).front() != "offset");
  }
}

/// What was refused at its own fit may be right beside another effect, without which its value is not the same.
void test_refused_alone_and_taken_beside_another() {
  LinearRecording both = catalogue(), far = catalogue();
  both.truth(0) = 0.6;
  both.truth(1) = 0.25;
  far.outside = [](int s, const Eigen::MatrixXd& J, Eigen::VectorXd* r) {
    *r += (is_held_out(s) ? 0.9 : 0.3) * J.col(6) + 0.25 * J.col(7);
  };
  int right = 0;
  for (int seed = 0; seed < 20; ++seed) {
    test::Random random(2200 + seed);
    const Problem alone = problem_of(far, &random), beside = problem_of(both, &random);
    const Selection s = select_effects(both.candidates, {}, [&](const std::vector<int>& accepted) {
      return std::count(accepted.begin(), accepted.end(), 1) > 0 ? beside : alone;
    });
    right += names(s) == std::vector<std::string>{"offset", "shutter"};
  }
  TEST_ASSERT_GREATER_OR_EQUAL_INT(19, right);  // the halves of a right effect disagree in one of a thousand
}

/// A drift of theta with time looks like a step in its middle, which is not held against its scatter, while an effect
/// whose rows are that drift is: its value scatters by a third from segment to segment. The effect has the name.
void test_an_effect_before_the_step_that_looks_like_it() {
  int right = 0;
  for (int seed = 0; seed < 20; ++seed) {
    LinearRecording recording = catalogue();
    test::Random random(2400 + seed);
    int segment = 0;
    recording.shape = [&](Eigen::MatrixXd* J) { J->col(6) = (segment++ - 5.5) / 3.5 * J->col(0) + 0.2 * J->col(6); };
    recording.truth(0) = 0.6;
    recording.outside = [&random](int, const Eigen::MatrixXd& J, Eigen::VectorXd* r) {
      *r += 0.2 * random.normal() * J.col(6);
    };
    const Problem problem = problem_of(recording, &random);
    const Selection s =
        select_effects(recording.candidates, {}, [&problem](const std::vector<int>&) { return problem; });
    right += !s.accepted.empty() && s.accepted.front().candidate == 0;
  }
  std::printf("effect before step: %d of 20\n", right);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(19, right);
}

/// No fit begins that less is left for than the last one took, and it is said where something was left to take.
void test_a_search_ends_with_its_budget() {
  LinearRecording recording = catalogue();
  recording.truth.setConstant(0.4);
  for (const int fits : {1, 2, 4, 9}) {
    test::Random random(2300);
    const Problem problem = problem_of(recording, &random);
    Budget budget(10 * fits + 9);
    SelectionOptions options;
    options.work = &budget;
    const Selection s = select_effects(recording.candidates, options, [&](const std::vector<int>&) {
      budget.take(10);
      return problem;
    });
    TEST_ASSERT_EQUAL_INT(std::min(fits - 1, 3), static_cast<int>(s.accepted.size()));
    TEST_ASSERT_EQUAL(fits < 4, budget.used_up());
  }
}

/// A round that the work left is not enough for must not begin, and the answer says that it was cut short.
void test_a_budget_knows_what_is_left() {
  Budget budget(10);
  TEST_ASSERT_TRUE(budget.allows(10) && budget.must_answer() && !budget.used_up());
  TEST_ASSERT_FALSE(budget.allows(11));
  TEST_ASSERT_TRUE(budget.used_up() && budget.allows_fit());
  budget.take(5);
  TEST_ASSERT_TRUE(budget.allows_fit());
  budget.take(1);
  TEST_ASSERT_TRUE(budget.allows_fit());
  budget.take(3);
  TEST_ASSERT_TRUE(budget.allows(1) && !budget.allows_fit());
}

/// A search that comes back to a fit does not make it again; with other noise it is another fit.
void test_a_fit_is_remembered() {
  host::SimulationOptions simulated;
  simulated.seconds = 15;
  simulated.seed = 31;
  const host::SimulationResult session = host::simulate(simulated);
  host::CoreOptions core;
  core.calibration = session.nominal;
  Budget budget(INT64_C(1) << 40);
  const std::vector<host::Recording> sessions = {session.recording};
  Evidence evidence(sessions, core, "host", &budget, nullptr);
  const Catalogue all = core_catalogue(false);
  const std::vector<bool> none(all.terms.size(), false);
  std::vector<bool> one = none;
  one[0] = true;
  const std::vector<double> start(all.terms.size(), 0);
  const auto cost = [&](const std::vector<bool>& estimated) {
    const std::int64_t before = budget.left();
    evidence.fit(all.terms, estimated, start);
    return before - budget.left();
  };
  TEST_ASSERT_TRUE(cost(none) > 0);
  const Eigen::MatrixXd R = evidence.fit(all.terms, none, start).all.R;
  TEST_ASSERT_TRUE(cost(one) > 0);
  TEST_ASSERT_EQUAL_INT(1, static_cast<int>(evidence.taken().size()));
  TEST_ASSERT_EQUAL_INT(0, static_cast<int>(cost(none)));
  TEST_ASSERT_EQUAL_INT(0, static_cast<int>(evidence.taken().size()));
  // Its core as well: rows with other candidates are asked there.
  TEST_ASSERT_TRUE(evidence.at_last_fit(all.terms, false).all.R == R);
  // What stands beside it is no part of it: other candidates are linearised at the fit that was made.
  std::vector<TermInfo> fewer(all.terms.begin(), all.terms.end() - 1);
  const std::int64_t left = budget.left();
  const Problem beside = evidence.fit(fewer, std::vector<bool>(fewer.size(), false), start);
  TEST_ASSERT_TRUE(left == budget.left());
  TEST_ASSERT_EQUAL_INT(R.cols() - 1, beside.all.R.cols());
  TEST_ASSERT_TRUE(evidence.fit(all.terms, none, start).all.R == R);
  evidence.options().pixel_sigma *= 1.5;
  TEST_ASSERT_TRUE(cost(none) > 0);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_the_dominant_one);
  RUN_TEST(test_what_says_most_is_tried_at_its_own_fit);
  RUN_TEST(test_refused_alone_and_taken_beside_another);
  RUN_TEST(test_an_effect_before_the_step_that_looks_like_it);
  RUN_TEST(test_a_search_ends_with_its_budget);
  RUN_TEST(test_a_budget_knows_what_is_left);
  RUN_TEST(test_a_fit_is_remembered);
  return UNITY_END();
}
