// Structure in residuals: white noise has none, a dependence on a cause is found and named, slow noise is not taken for one.
#include <cmath>
#include <vector>

#include "../support/cases.h"
#include "../support/random.h"
#include "diagnose/structure.h"

using namespace host::diagnosis;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr int kCount = 2000;
constexpr double kLevel = -3;

/// Noise of unit variance with neighbours alike by `alike`, held against slow sines of rate and force and against time.
ResidualList noise_list(test::Random* random, double alike) {
  ResidualList list{"gyro", "x", {}, {}, {}};
  double slow = 0;
  for (int i = 0; i < kCount; ++i) {
    slow = alike * slow + std::sqrt(1 - alike * alike) * random->normal();
    list.value.push_back(slow);
    list.series.push_back(i / 100);
    list.cause[static_cast<int>(Cause::time)].push_back(0.03 * i);
    list.cause[static_cast<int>(Cause::rate_y)].push_back(std::sin(0.05 * i) + random->normal(0.1));
    list.cause[static_cast<int>(Cause::force_z)].push_back(9.8 + std::cos(0.07 * i) + random->normal(0.1));
  }
  return list;
}

void test_noise_has_no_structure() {
  int white = 0, slow = 0;
  for (int seed = 0; seed < 100; ++seed) {
    test::Random random(seed);
    white += find_structure({noise_list(&random, 0)}, kLevel, 3).empty() ? 0 : 1;
    slow += find_structure({noise_list(&random, 0.6)}, kLevel, 3).empty() ? 0 : 1;
  }
  TEST_ASSERT_LESS_OR_EQUAL_INT(2, white);  // 0.1 expected
  TEST_ASSERT_LESS_OR_EQUAL_INT(3, slow);
}

/// A quarter of a sigma over the range of the cause, straight or bent.
void test_dependence_is_named() {
  for (const bool bent : {false, true}) {
    for (int seed = 0; seed < 20; ++seed) {
      test::Random random(200 + seed);
      ResidualList list = noise_list(&random, 0);
      for (int i = 0; i < kCount; ++i) {
        const double rate = list.cause[static_cast<int>(Cause::rate_y)][i];
        list.value[i] += bent ? 0.6 * rate * rate : 0.25 * rate;
      }
      const std::vector<Structure> found = find_structure({list}, kLevel, 3);
      TEST_ASSERT_FALSE(found.empty());
      TEST_ASSERT_EQUAL_STRING("rate y", found.front().against.c_str());
      TEST_ASSERT_TRUE(std::abs(found.front().correlation) > 0.1);
    }
  }
}

void test_autocorrelation() {
  test::Random random(7);
  // Standard error of a correlation of 2000 numbers: 0.022.
  TEST_ASSERT_DOUBLE_WITHIN(0.09, 0, lag_one_autocorrelation(noise_list(&random, 0)));
  TEST_ASSERT_DOUBLE_WITHIN(0.09, 0.6, lag_one_autocorrelation(noise_list(&random, 0.6)));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_noise_has_no_structure);
  RUN_TEST(test_dependence_is_named);
  RUN_TEST(test_autocorrelation);
  return UNITY_END();
}
