// What an effect may move that leaves no residual: two values and one effect, whose covariances are known on paper.
#include <cmath>
#include <string>

#include "review/unseen_effects.h"
#include "unity.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace host::diagnosis;
using host::CoreParameter;
using host::UnseenEffect;

constexpr double kRounding = 1e-12;  // of numbers of about 1

/// Values a and b and an effect c, plausible size 0.5: 100 measurements of a + c and 400 of b, of unit noise, and no
/// more of c than `seen` measurements of it alone. The prior on a and b is as good as none.
Problem confounded(double seen) {
  Problem out;
  out.n_theta = 2;
  out.prior.mean = Eigen::VectorXd::Zero(2);
  out.prior.sigma = Eigen::VectorXd::Constant(2, 1e9);
  out.all.R = Eigen::MatrixXd::Zero(4, 4);
  out.all.R(0, 0) = out.all.R(0, 2) = 10;
  out.all.R(1, 1) = 20;
  out.all.R(2, 2) = std::sqrt(seen);
  out.all.dof = 500;
  return out;
}

std::vector<CoreParameter> parameters(double sigma_a) {
  std::vector<CoreParameter> out(2);
  out[0].name = "gyro.sx";
  out[1].name = "gyro.sy";
  out[0].sigma = sigma_a;
  out[1].sigma = 0.05;
  for (CoreParameter& p : out) {
    p.unit = "-";
    p.verdict = "observed";
  }
  return out;
}

const Candidate kEffect{"gyro_nonlinearity", {0, 1}, {0.5}};

/// The variance of a grows by that of c: 1 / (1 / 0.5^2 + seen); b does not move.
void test_moves_are_those_of_the_effect() {
  for (const double seen : {0.0, 12.0, 1e4}) {
    const UnseenEffect e = host::review::unseen_effect(confounded(seen), kEffect, 1, parameters(0.1));
    TEST_ASSERT_EQUAL_STRING("gyro_nonlinearity", e.name.c_str());
    TEST_ASSERT_DOUBLE_WITHIN(kRounding, std::sqrt(1 / (4 + seen)), e.moves[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0, e.moves[1]);  // the root of rounding
  }
}

/// Measurements of four times the noise variance tell four times less of c.
void test_noise_counts() {
  const UnseenEffect e = host::review::unseen_effect(confounded(12), kEffect, 4, parameters(0.1));
  TEST_ASSERT_DOUBLE_WITHIN(kRounding, std::sqrt(1 / (4 + 12.0 / 4)), e.moves[0]);
}

host::ReplayResult calibrated(const std::vector<UnseenEffect>& unseen) {
  host::ReplayResult out;
  out.result.status = "calibrated";
  out.result.parameters = parameters(0.1);
  out.health.unseen = unseen;
  out.health.notes = {{"gravity", 1, "as it was"}};
  return out;
}

/// The words of the note; empty without one. Twice makes no second note, and others stay.
std::string noted(host::ReplayResult result) {
  host::review::note_unseen_effects(&result);
  host::review::note_unseen_effects(&result);
  TEST_ASSERT_EQUAL_STRING("gravity", result.health.notes.at(0).name.c_str());
  TEST_ASSERT_TRUE(result.health.notes.size() <= 2);
  return result.health.notes.size() == 2 ? result.health.notes[1].words : "";
}

/// 0.5 is five of a's sigmas; 0.1 is two of b's, too few.
void test_note_names_what_moves() {
  const host::ReplayResult result = calibrated({{"gyro_nonlinearity", {0.5, 0.1}}});
  const std::string words = noted(result);
  TEST_ASSERT_TRUE_MESSAGE(words.find("gyro_nonlinearity (gyro.sx by 0.5, 5 sigma)") != std::string::npos,
                           words.c_str());
  host::ReplayResult fixed = result, refused = result, suspected = result, wide = result;
  fixed.result.parameters[0].verdict = "fixed";
  refused.result.status = "failed";
  suspected.health.suspects.push_back({"gyro_nonlinearity", 0, 0, 0, "", "", 0, {}});
  wide.result.parameters[0].sigma = 0.2;
  for (const host::ReplayResult& silent : {fixed, refused, suspected, wide})
    TEST_ASSERT_EQUAL_STRING("", noted(silent).c_str());
}

void test_the_worst_is_named_first() {
  const std::string words = noted(calibrated({{"a", {0.4, 0}}, {"b", {0, 0.5}}, {"c", {0.5, 0}}, {"d", {0, 0.2}}}));
  TEST_ASSERT_TRUE_MESSAGE(
      words.find("b (gyro.sy by 0.5, 10 sigma), c (gyro.sx by 0.5, 5 sigma), ") != std::string::npos, words.c_str());
  TEST_ASSERT_TRUE_MESSAGE(words.find(" and 1 more") != std::string::npos, words.c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_moves_are_those_of_the_effect);
  RUN_TEST(test_noise_counts);
  RUN_TEST(test_note_names_what_moves);
  RUN_TEST(test_the_worst_is_named_first);
  return UNITY_END();
}
