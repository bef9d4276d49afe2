// What only an earlier replay of the same recordings suspects: kept, in the sigmas of now, and judged by them.
#include <unity.h>

#include "review/missing_effects.h"
#include "review/take_back.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

host::ReplayResult calibrated(double sigma) {
  host::ReplayResult out;
  out.result.status = "calibrated";
  host::CoreParameter p;
  p.name = "gyro.sx";
  p.sigma = sigma;
  p.verdict = "observed";
  out.result.parameters.push_back(p);
  return out;
}

host::Suspect suspect(const char* name, double bias_sigmas) {
  host::Suspect out;
  out.name = name;
  out.bias_sigmas = bias_sigmas;
  out.moves = "gyro.sx";
  out.words = "words";
  return out;
}

/// 2 sigmas are 2.8 and 3.2 where sigma falls to 2 / 2.8 and 2 / 3.2.
void test_an_effect_counts_in_the_sigmas_of_now() {
  host::ReplayResult earlier = calibrated(1e-3);
  earlier.health.suspects.push_back(suspect("gyro_lag", 2));
  for (const double bias : {2.8, 3.2}) {
    host::ReplayResult now = calibrated(1e-3 * 2 / bias);
    host::review::keep_suspects(earlier, &now);
    TEST_ASSERT_EQUAL_UINT(1, now.health.suspects.size());
    const host::Suspect& kept = now.health.suspects.at(0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, bias, kept.bias_sigmas);  // rounding
    TEST_ASSERT_TRUE(kept.words.find(bias > 3 ? "3.2 sigma" : "2.8 sigma") != std::string::npos);
    TEST_ASSERT_EQUAL_STRING(bias > 3 ? "failed" : "calibrated", now.result.status.c_str());
    TEST_ASSERT_EQUAL_STRING(bias > 3 ? kept.words.c_str() : "", now.cause.c_str());
  }
}

/// It was looked for again.
void test_a_step_of_a_bias_is_only_said() {
  host::ReplayResult earlier = calibrated(1e-3), now = calibrated(1e-4);
  earlier.health.suspects.push_back(suspect("bias_step.gyro", 1.9));
  host::review::keep_suspects(earlier, &now);
  TEST_ASSERT_EQUAL_UINT(1, now.health.suspects.size());
  TEST_ASSERT_EQUAL_STRING("words", now.health.suspects.at(0).words.c_str());
  TEST_ASSERT_EQUAL_STRING("calibrated", now.result.status.c_str());
}

/// The later review judged it itself.
void test_what_both_suspect_is_not_taken_twice() {
  host::ReplayResult earlier = calibrated(1e-3), now = calibrated(1e-4);
  earlier.health.suspects.push_back(suspect("gyro_lag", 2));
  now.health.suspects.push_back(suspect("gyro_lag", 0.5));
  host::review::keep_suspects(earlier, &now);
  TEST_ASSERT_EQUAL_UINT(1, now.health.suspects.size());
  TEST_ASSERT_EQUAL_STRING("calibrated", now.result.status.c_str());
}

/// Not the one with the largest statistic, which stands first.
void test_the_cause_is_what_moves_most() {
  TEST_ASSERT_NULL(host::review::most_moving({}));
  const std::vector<host::Suspect> missing = {suspect("radial_residual", 0.4), suspect("gyro_lag", 5),
                                              suspect("time_offset", 4)};
  TEST_ASSERT_EQUAL_STRING("gyro_lag", host::review::most_moving(missing)->name.c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_an_effect_counts_in_the_sigmas_of_now);
  RUN_TEST(test_a_step_of_a_bias_is_only_said);
  RUN_TEST(test_the_cause_is_what_moves_most);
  RUN_TEST(test_what_both_suspect_is_not_taken_twice);
  return UNITY_END();
}
