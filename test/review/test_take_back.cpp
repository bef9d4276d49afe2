// What only an earlier replay of the same recordings suspects: kept, in the sigmas of now, and judged by them.
#include <unity.h>

#include <cmath>

#include "review/missing_effects.h"
#include "review/suspected_moves.h"
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
  p.prior_sigma = 1;
  out.result.covariance = {sigma * sigma};
  p.verdict = "observed";
  out.result.parameters.push_back(p);
  out.health.noise_sigmas = {sigma};
  return out;
}

/// With sigmas of 1e-3, as calibrated(1e-3) has.
host::Suspect suspect(const char* name, double bias_sigmas) {
  host::Suspect out;
  out.move = -1e-3 * bias_sigmas;
  out.moved = {out.move};
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
    TEST_ASSERT_EQUAL_INT(bias < 3, kept.in_sigmas);
    const double grown = bias < 3 ? std::sqrt(1 + bias * bias) : 1;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, grown * 1e-3 * 2 / bias, now.result.parameters.at(0).sigma);
  }
}

/// 3.2 sigmas that nobody is sure of: held, as above, and no reason to refuse.
void test_an_uncertain_effect_refuses_nothing() {
  host::ReplayResult earlier = calibrated(1e-3), now = calibrated(1e-3 * 2 / 3.2);
  earlier.health.suspects.push_back(suspect("gyro_lag", 2));
  earlier.health.suspects.front().certain = false;
  host::review::keep_suspects(earlier, &now);
  TEST_ASSERT_EQUAL_STRING("calibrated", now.result.status.c_str());
  TEST_ASSERT_TRUE(now.health.suspects.at(0).in_sigmas);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, std::sqrt(1 + 3.2 * 3.2) * 1e-3 * 2 / 3.2, now.result.parameters.at(0).sigma);
  TEST_ASSERT_NULL(host::review::most_moving(now.health.suspects));
  host::Suspect step = suspect("bias_step.gyro", 4);
  TEST_ASSERT_FALSE(host::review::explains_more(now.health.suspects, step));
  now.health.suspects.front().certain = true;
  now.health.suspects.front().statistic = 1;
  TEST_ASSERT_TRUE(host::review::explains_more(now.health.suspects, step));
}

/// Both replays show it, and only the first is sure: it refuses by what it moves now.
void test_one_certain_replay_is_enough() {
  for (const double bias : {2.0, 4.0}) {
    host::ReplayResult earlier = calibrated(1e-3), now = calibrated(1e-3);
    earlier.health.suspects.push_back(suspect("gyro_lag", 2));
    now.health.suspects.push_back(suspect("gyro_lag", bias));
    now.health.suspects.front().certain = false;
    now.health.suspects.front().words = "perhaps";
    host::review::keep_suspects(earlier, &now);
    TEST_ASSERT_EQUAL_UINT(1, now.health.suspects.size());
    TEST_ASSERT_TRUE(now.health.suspects.at(0).certain);
    TEST_ASSERT_EQUAL_STRING("words", now.health.suspects.at(0).words.c_str());
    TEST_ASSERT_EQUAL_STRING(bias > 3 ? "failed" : "calibrated", now.result.status.c_str());
    TEST_ASSERT_EQUAL_STRING(bias > 3 ? "words" : "", now.cause.c_str());
  }
}

/// It was looked for again.
void test_a_step_is_only_said() {
  for (const char* name : {"bias_step.gyro", "calibration_shift.cam0.r_CI"}) {
    host::ReplayResult earlier = calibrated(1e-3), now = calibrated(1e-4);
    earlier.health.suspects.push_back(suspect(name, 1.9));
    host::review::keep_suspects(earlier, &now);
    TEST_ASSERT_EQUAL_UINT(1, now.health.suspects.size());
    TEST_ASSERT_EQUAL_STRING("words", now.health.suspects.at(0).words.c_str());
    TEST_ASSERT_EQUAL_STRING("calibrated", now.result.status.c_str());
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1e-4, now.result.parameters.at(0).sigma);
  }
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

host::CoreParameter parameter(const char* verdict, double sigma, double prior_sigma) {
  host::CoreParameter out;
  out.verdict = verdict;
  out.sigma = sigma;
  out.prior_sigma = prior_sigma;
  return out;
}

/// At least noise and movement together; what segments scatter by is not added to that. A value goes no farther than
/// its prior, a fixed one not at all.
void test_sigmas_grow_by_what_is_suspected() {
  host::ReplayResult r;
  r.result.parameters = {parameter("observed", 3, 100), parameter("observed", 1, 2), parameter("fixed", 1, 1),
                         parameter("observed", 6, 100), parameter("observed", 7, 100)};
  r.health.noise_sigmas = {3, 1, 1, 4.5, 7};
  r.result.covariance.assign(25, 0);
  for (std::size_t i = 0; i < 5; ++i) r.result.covariance[6 * i] = std::pow(r.result.parameters[i].sigma, 2);
  host::Suspect s;
  s.moved = {-4, 50, 1, 3};  // of theta's columns: the effect's own has none
  host::review::widen_by(s, &r);
  TEST_ASSERT_TRUE(s.in_sigmas);
  const double sigmas[] = {5, 2, 1, 6, 7};  // 3-4-5; the prior's; fixed; 4.5 and 3 are less than 6; not moved
  for (std::size_t i = 0; i < 5; ++i) {
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, sigmas[i], r.result.parameters[i].sigma);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, sigmas[i] * sigmas[i], r.result.covariance[6 * i]);
  }
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, -4 * std::sqrt(3), r.result.covariance[1]);
  const char* const verdicts[] = {"observed", "weak", "fixed", "observed", "observed"};
  for (std::size_t i = 0; i < 5; ++i) TEST_ASSERT_EQUAL_STRING(verdicts[i], r.result.parameters[i].verdict.c_str());
  host::Suspect other;  // explains the same residuals, and less
  other.moved = {3};
  host::review::widen_by(other, &r);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 5, r.result.parameters[0].sigma);
  host::Suspect fault;
  host::review::widen_by(fault, &r);
  TEST_ASSERT_FALSE(fault.in_sigmas);
}

/// With the first replay's suspect in the sigmas nothing is observed any more.
void test_too_few_are_observed_then() {
  host::ReplayResult earlier = calibrated(0.4), now = calibrated(0.4);
  earlier.health.suspects.push_back(suspect("gyro_lag", 1.5));
  earlier.health.suspects.back().move = 0.6;
  earlier.health.suspects.back().moved = {0.6};
  host::review::keep_suspects(earlier, &now);
  TEST_ASSERT_EQUAL_STRING("insufficient", now.result.status.c_str());
  TEST_ASSERT_TRUE(now.cause.find("what gyro_lag would move, in the sigmas, 0 of 1 ") != std::string::npos);
}

/// Then that is said beside the segments' scatter.
void test_too_few_are_observed_without_one_segment() {
  host::ReplayResult now = calibrated(0.4);
  now.result.parameters[0].verdict = "weak";
  now.health.segment_scatter = 1.44;
  now.health.notes.push_back({"one_segment", 2.5, "one segment tells it"});
  host::review::refuse_unobserved(&now);
  TEST_ASSERT_EQUAL_STRING("insufficient", now.result.status.c_str());
  TEST_ASSERT_EQUAL_STRING(
      "the segments disagree with each other by 1.2 times their noise, and one segment tells it; "
      "with that in the sigmas, 0 of 1 parameters are observed",
      now.cause.c_str());
}

void test_chance_is_no_bias() {
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, -4, host::review::beyond_chance(-5, 3));
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, host::review::beyond_chance(2, 3));
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2, host::review::beyond_chance(2, NAN));
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
  RUN_TEST(test_an_uncertain_effect_refuses_nothing);
  RUN_TEST(test_one_certain_replay_is_enough);
  RUN_TEST(test_a_step_is_only_said);
  RUN_TEST(test_the_cause_is_what_moves_most);
  RUN_TEST(test_sigmas_grow_by_what_is_suspected);
  RUN_TEST(test_too_few_are_observed_then);
  RUN_TEST(test_too_few_are_observed_without_one_segment);
  RUN_TEST(test_chance_is_no_bias);
  RUN_TEST(test_what_both_suspect_is_not_taken_twice);
  return UNITY_END();
}
