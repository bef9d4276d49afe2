// Image coordinates in 16 bits: what goes in comes out within half a step, and what does not fit is known beforehand.
#include <limits>

#include "../support/cases.h"
#include "../support/random.h"
#include "segments/pixel.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

void check(float px) {
  const Id id = Id().add("px", px);
  test::check_true(id, "fits", PackedPixel::holds(px));
  // Half a step of 1/32 px; the sum with the margin rounds in the seventh digit of 2048.
  test::check_near(id, "stored", px, static_cast<float>(PackedPixel(px)), 0.5 / 32 + 2e-4);
}

void test_within_half_a_step() {
  test::Random random(7);
  for (int i = 0; i < 10000; ++i) check(static_cast<float>(random.uniform(-64, 1983.9)));
}

void test_ends_of_the_range() {
  for (const float px : {-64.f, -63.99f, -0.01f, 0.f, 1983.f, 1983.96f}) check(px);
  for (const float px : {-64.1f, 1984.f, 1e9f, -1e9f, std::numeric_limits<float>::quiet_NaN()}) {
    test::check_true(Id().add("px", px), "refused", !PackedPixel::holds(px));
  }
}

/// A stored value stays what it is however often it is stored again: segments are copied and hashed.
void test_storing_again_changes_nothing() {
  test::Random random(8);
  for (int i = 0; i < 10000; ++i) {
    const float once = PackedPixel(static_cast<float>(random.uniform(-64, 1983.9)));
    TEST_ASSERT_EQUAL_FLOAT(once, static_cast<float>(PackedPixel(once)));
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_within_half_a_step);
  RUN_TEST(test_ends_of_the_range);
  RUN_TEST(test_storing_again_changes_nothing);
  return UNITY_END();
}
