// When a start in motion that was refused is tried again: at the next frames first, then ever more rarely, and the
// sooner the less it missed.
#include <unity.h>

#include "vio/vio.h"

using namespace SEGCAL_NS;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr std::int64_t kFrame = 100000000;

/// Of frames at 10 Hz from the first try on, the places of those that are tried, each with this lack.
std::vector<int> tried(float lack, int frames) {
  std::vector<int> out = {0};
  for (int i = 1; i < frames; ++i) {
    if (!too_soon_to_start<float>(0, out.back() * kFrame, i * kFrame, lack)) out.push_back(i);
  }
  return out;
}

/// What is just beyond acceptable may be right at the next frame.
void test_a_near_miss_is_tried_at_each_frame() { TEST_ASSERT_EQUAL_size_t(50, tried(1.1f, 50).size()); }

/// 0, 0.1, ... 0.4 s: a quarter of the time is no frame yet. From 2 s on it is half a second.
void test_a_far_one_waits_for_a_quarter_of_the_time() {
  const std::vector<int> expected = {0, 1, 2, 3, 4, 6, 8, 11, 15, 20, 25, 30};
  const std::vector<int> is = tried(10, 35);
  TEST_ASSERT_EQUAL_size_t(expected.size(), is.size());
  for (std::size_t i = 0; i < is.size(); ++i) TEST_ASSERT_EQUAL_INT(expected[i], is[i]);
  TEST_ASSERT_TRUE(tried(1.5f, 35).size() > is.size());
}

/// Not a number: as far as can be.
void test_what_cannot_be_told_waits() { TEST_ASSERT_EQUAL_size_t(tried(10, 35).size(), tried(0.0f / 0.0f, 35).size()); }

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_near_miss_is_tried_at_each_frame);
  RUN_TEST(test_a_far_one_waits_for_a_quarter_of_the_time);
  RUN_TEST(test_what_cannot_be_told_waits);
  return UNITY_END();
}
