// An answer of which one segment tells most, on linear problems: said, and as uncertain as without that segment.
#include <Eigen/LU>

#include "../diagnosis/linear_problem.h"
#include "../support/cases.h"
#include "review/one_segment.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

/// Eight segments; one of them tells `times` as much of theta's first entry, by sigmas.
host::diagnosis::Problem problem_with_a_strong_one(double times, int segments = 8) {
  test::Random random(7);
  test::LinearRecording recording;
  recording.segments = segments;
  recording.truth = Eigen::VectorXd();
  int segment = 0;
  recording.shape = [&segment, times](Eigen::MatrixXd* J) {
    if (segment++ == 1) J->col(0) *= times;
  };
  return test::problem_of(recording, &random);
}

host::review::OneSegment asked(const host::diagnosis::Problem& problem) {
  // A value is half the first column, so that rows of printed values count.
  Eigen::MatrixXd printed = Eigen::MatrixXd::Identity(6, 6);
  printed(0, 0) = 0.5;
  const Eigen::MatrixXd R = host::diagnosis::with_prior(problem.all, problem.prior).R.leftCols(6);
  const Eigen::MatrixXd covariance = printed * (R.transpose() * R).inverse() * printed.transpose();
  return host::review::rests_on_one_segment(problem.pieces, printed, covariance);
}

void test_equal_segments_change_nothing() {
  const auto one = asked(problem_with_a_strong_one(1));
  TEST_ASSERT_TRUE(one.values.empty());
  TEST_ASSERT_TRUE((one.variance_factor.array() == 1).all());
  TEST_ASSERT_FALSE(host::review::note_on_one_segment(one, {}).has_value());
}

/// 7 + k^2 parts of information, of which 7 are the others'. At k = 4 a variance grows by 23/7 = 3.3, which is borne;
/// at k = 6 by 43/7 = 6.1. The square sum of 120 random rows scatters by an eighth, twice that is allowed.
void test_what_one_segment_tells_alone() {
  TEST_ASSERT_TRUE(asked(problem_with_a_strong_one(4)).values.empty());
  const auto one = asked(problem_with_a_strong_one(6));
  TEST_ASSERT_EQUAL_INT(1, static_cast<int>(one.values.size()));
  TEST_ASSERT_EQUAL_INT(0, one.values[0]);
  test::check_near(Id(), "variance without it", 43.0 / 7, one.variance_factor(0), 0.25 * 43 / 7);
  test::check_near(Id(), "sigma without it", std::sqrt(one.variance_factor(0)), one.largest, 1e-12);
  // The other values: seven segments of eight.
  for (int i = 1; i < 6; ++i) test::check_near(Id(), "of another value", 8.0 / 7, one.variance_factor(i), 0.1);
  std::vector<host::CoreParameter> parameters(6);
  parameters[0].name = "accel.mz";
  const auto note = host::review::note_on_one_segment(one, parameters);
  TEST_ASSERT_TRUE(note.has_value());
  TEST_ASSERT_EQUAL_STRING("one_segment", note->name.c_str());
  TEST_ASSERT_TRUE(note->words.find("known of accel.mz, and") != std::string::npos);
}

void test_two_segments_are_not_asked() { TEST_ASSERT_TRUE(asked(problem_with_a_strong_one(6, 2)).values.empty()); }

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_equal_segments_change_nothing);
  RUN_TEST(test_what_one_segment_tells_alone);
  RUN_TEST(test_two_segments_are_not_asked);
  return UNITY_END();
}
