// An answer of which one segment tells most, on linear problems: said, and as uncertain as without that segment.
#include "../diagnosis/linear_problem.h"
#include "../support/cases.h"
#include "review/names.h"
#include "review/one_segment.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

/// Segment 1 tells `times` as much of theta's first entry as the others, by sigmas, segment 3 `of_second` of the
/// second.
host::diagnosis::Problem problem_of(double times, int segments = 8, double of_second = 1) {
  test::Random random(7);
  test::LinearRecording recording;
  recording.segments = segments;
  recording.truth = Eigen::VectorXd();
  int segment = 0;
  recording.shape = [&segment, times, of_second](Eigen::MatrixXd* J) {
    if (segment == 1) J->col(0) *= times;
    if (segment == 3) J->col(1) *= of_second;
    ++segment;
  };
  return test::problem_of(recording, &random);
}

/// A value is half the first column, so that rows of printed values count.
host::review::OneSegment asked(const host::diagnosis::Problem& problem) {
  Eigen::MatrixXd printed = Eigen::MatrixXd::Identity(6, 6);
  printed(0, 0) = 0.5;
  return host::review::rests_on_one_segment(problem, printed);
}

void test_equal_segments_change_nothing() {
  for (const int segments : {2, 3, 8}) {
    const auto one = asked(problem_of(1, segments));
    TEST_ASSERT_TRUE(one.values.empty());
    TEST_ASSERT_TRUE((one.variance_factor.array() == 1).all());
    TEST_ASSERT_FALSE(host::review::note_on_one_segment(one, {}).has_value());
  }
}

/// 7 + k^2 parts of information, of which 7 are the others'. At k = 4 a variance grows by 23/7 = 3.3, which is borne;
/// at k = 6 by 43/7 = 6.1. The square sum of 120 random rows scatters by an eighth, twice that is allowed.
void test_what_one_segment_tells_alone() {
  TEST_ASSERT_TRUE(asked(problem_of(4)).values.empty());
  const auto one = asked(problem_of(6));
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

/// Two values rest on two segments: each is as uncertain as without its own.
void test_two_such_segments() {
  const auto one = asked(problem_of(6, 8, 8));
  TEST_ASSERT_EQUAL_INT(2, static_cast<int>(one.values.size()));
  test::check_near(Id(), "the first", 43.0 / 7, one.variance_factor(0), 0.25 * 43 / 7);
  test::check_near(Id(), "the second", 71.0 / 7, one.variance_factor(1), 0.25 * 71 / 7);
  test::check_near(Id(), "largest", std::sqrt(one.variance_factor(1)), one.largest, 1e-12);
}

/// What only one segment tells is known as before without it.
void test_the_prior_remains() {
  const auto one = asked(problem_of(1e6, 2));
  test::check_true(Id(), "finite", one.variance_factor.allFinite());
  test::check_true(Id(), "large", one.variance_factor(0) > 1e3);
}

void test_names() {
  TEST_ASSERT_EQUAL_STRING("a", host::review::names_of({"a"}).c_str());
  TEST_ASSERT_EQUAL_STRING("a and b", host::review::names_of({"a", "b"}).c_str());
  TEST_ASSERT_EQUAL_STRING("a, b and c", host::review::names_of({"a", "b", "c"}).c_str());
  TEST_ASSERT_EQUAL_STRING("a, b, c and 2 more", host::review::names_of({"a", "b", "c", "d", "e"}).c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_equal_segments_change_nothing);
  RUN_TEST(test_what_one_segment_tells_alone);
  RUN_TEST(test_two_such_segments);
  RUN_TEST(test_the_prior_remains);
  RUN_TEST(test_names);
  return UNITY_END();
}
