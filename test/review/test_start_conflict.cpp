// Weak values that went further from their start than start and recording together let expect.
#include "../support/cases.h"
#include "review/start_conflict.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

/// One length that went by `step` start sigmas and is known to `share` of the start's sigma.
std::vector<host::CoreParameter> parameters(double step, double share, const char* verdict) {
  std::vector<host::CoreParameter> p(1);
  p[0].name = "cam0.p_CI.z";
  p[0].initial = -0.03;
  p[0].prior_sigma = 0.03;
  p[0].value = p[0].initial + step * p[0].prior_sigma;
  p[0].sigma = share * p[0].prior_sigma;
  p[0].verdict = verdict;
  return p;
}

double factor_of(double step, double share, const char* verdict) {
  const std::vector<host::CoreParameter> p = parameters(step, share, verdict);
  return host::review::start_conflict_factor(p[0], host::review::steps_in_their_sigmas(p, {p[0].sigma})[0]);
}

/// A posterior of 0.6 start sigmas leaves 0.8 of them to the step: 0.6^2 + 0.8^2 = 1.
void test_a_step_in_its_sigmas() {
  const Id id;
  test::check_near(id, "step", 4, host::review::steps_in_their_sigmas(parameters(-3.2, 0.6, "weak"), {0.018})[0],
                   1e-12);
  test::check_near(id, "fixed", 0, host::review::steps_in_their_sigmas(parameters(-3.2, 0.6, "fixed"), {0.018})[0], 0);
  test::check_near(id, "known as its start", 0,
                   host::review::steps_in_their_sigmas(parameters(-3.2, 1, "weak"), {0.03})[0], 0);
}

void test_weak_values_only_and_beyond_three() {
  const Id id;
  test::check_near(id, "far", 4, factor_of(-3.2, 0.6, "weak"), 1e-12);
  test::check_near(id, "near", 1, factor_of(2.3, 0.6, "weak"), 0);  // 2.9 of the step's sigmas
  // What is observed leaves a start behind that was five times as far off as stated.
  test::check_near(id, "observed", 1, factor_of(5, 0.1, "observed"), 0);
}

void test_the_note_names_the_largest() {
  std::vector<host::CoreParameter> two = parameters(1, 0.6, "weak");
  two.push_back(parameters(-3.2, 0.6, "weak")[0]);
  two[0].name = "cam0.p_CI.y";
  TEST_ASSERT_FALSE(host::review::note_on_start_conflict(two, {1, 1}).has_value());
  TEST_ASSERT_FALSE(host::review::note_on_start_conflict({}, {}).has_value());
  const auto note = host::review::note_on_start_conflict(two, {1, 4});
  TEST_ASSERT_TRUE(note.has_value());
  TEST_ASSERT_EQUAL_STRING("start_conflict", note->name.c_str());
  TEST_ASSERT_EQUAL_DOUBLE(4, note->factor);
  TEST_ASSERT_TRUE(note->words.rfind("cam0.p_CI.z went from -0.03 to -0.126, 4.0 times", 0) == 0);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_step_in_its_sigmas);
  RUN_TEST(test_weak_values_only_and_beyond_three);
  RUN_TEST(test_the_note_names_the_largest);
  return UNITY_END();
}
