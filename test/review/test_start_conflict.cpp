// Weak values that are further from their start than start and recording together let expect.
#include "../support/cases.h"
#include "review/start_conflict.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

/// A length that is `step` of its start's sigmas from it, and known to `share` of them.
host::CoreParameter length(const char* name, double step, double share, const char* verdict) {
  host::CoreParameter p;
  p.name = name;
  p.initial = -0.03;
  p.prior_sigma = 0.03;
  p.value = p.initial + step * p.prior_sigma;
  p.sigma = share * p.prior_sigma;
  p.verdict = verdict;
  return p;
}

double factor_of(double step, double share, const char* verdict) {
  return host::review::start_conflict_factors({length("cam0.p_CI.z", step, share, verdict)})[0];
}

void test_weak_values_beyond_three_only() {
  const Id id;
  test::check_near(id, "far", 3.2, factor_of(-3.2, 0.6, "weak"), 1e-12);
  test::check_near(id, "known as its start", 6, factor_of(6, 1, "weak"), 1e-12);
  test::check_near(id, "near", 1, factor_of(2.9, 0.6, "weak"), 0);
  test::check_near(id, "held", 1, factor_of(6, 1, "fixed"), 0);
  // What the recording tells well leaves a start behind that was five times as far off as stated.
  test::check_near(id, "observed", 1, factor_of(5, 0.1, "observed"), 0);
  test::check_near(id, "better than half", 1, factor_of(5, 0.4, "weak"), 0);
}

void test_the_note_names_all_and_tells_of_the_largest() {
  const std::vector<host::CoreParameter> two = {length("cam0.p_CI.y", 3.1, 0.9, "weak"),
                                                length("cam0.p_CI.z", -3.2, 0.6, "weak")};
  TEST_ASSERT_FALSE(host::review::note_on_start_conflict(two, {1, 1}).has_value());
  TEST_ASSERT_FALSE(host::review::note_on_start_conflict({}, {}).has_value());
  const auto note = host::review::note_on_start_conflict(two, host::review::start_conflict_factors(two));
  TEST_ASSERT_TRUE(note.has_value());
  TEST_ASSERT_EQUAL_STRING("start_conflict", note->name.c_str());
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 3.2, note->factor);
  const std::string begins = "the recording tells little more of cam0.p_CI.y and cam0.p_CI.z than the start";
  TEST_ASSERT_TRUE(note->words.rfind(begins, 0) == 0);
  TEST_ASSERT_TRUE(note->words.find("(cam0.p_CI.z went from -0.03 to -0.126, by 3.2 of") != std::string::npos);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_weak_values_beyond_three_only);
  RUN_TEST(test_the_note_names_all_and_tells_of_the_largest);
  return UNITY_END();
}
