// How a change of the device is told: when, and by which entries; and how it changes over sessions.
#include <unity.h>

#include "replay/words.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

using namespace host;

namespace {

CoreResult three_parameters() {
  CoreResult result;
  for (const auto& [name, unit] : {std::pair{"cam0.r_CI.x", "rad"}, {"cam0.p_CI.x", "m"}, {"gyro.sx", "-"}}) {
    CoreParameter p;
    p.name = name;
    p.unit = unit;
    result.parameters.push_back(p);
  }
  return result;
}

CoreChange change(std::vector<double> step, std::vector<double> sigma) {
  CoreChange c;
  c.before_session = 0;
  c.after_session = 1;
  c.t_ns = 12300000000;
  c.step = step;
  c.sigma = sigma;
  return c;
}

void check_words(const char* expected, const CoreChange& c) {
  TEST_ASSERT_EQUAL_STRING(expected, change_words(c, three_parameters()).c_str());
}

void test_sure_entries_are_named_in_order_of_sigmas() {
  check_words(
      "the device changed between session 1 and 2: gyro.sx by 0.05 +- 0.001, cam0.r_CI.x by -0.0087 +- 0.002 rad",
      change({-0.0087, 0.002, 0.05}, {0.002, 0.001, 0.001}));
}

/// Nobody may read 1.5 sigmas as that entry's own change.
void test_where_no_entry_is_sure_the_words_say_so() {
  check_words(
      "the device changed between session 1 and 2: no entry alone is sure, all together are; most of all cam0.r_CI.x "
      "by 0.003 +- 0.002 rad",
      change({0.003, 0.001, 0}, {0.002, 0.001, 0}));
}

void test_a_change_within_a_session_has_a_time() {
  CoreChange c = change({0, 0.02, 0}, {0.002, 0.001, 0.001});
  c.before_session = 1;
  check_words("the device changed within session 2, 12.3 s on the IMU's clock: cam0.p_CI.x by 0.02 +- 0.001 m", c);
}

CoreResult changing(std::vector<std::string> courses, const char* rate_of) {
  CoreResult result = three_parameters();
  result.course.courses = courses;
  result.course.rate_of = rate_of;
  result.course.sessions = 8;
  result.course.step_session = 4;
  result.course.rate = {0, 0.002, 0};
  result.course.sigma = {0, 0.0001, 0};
  return result;
}

void test_courses_are_told() {
  TEST_ASSERT_EQUAL_STRING("", course_words(changing({"steps"}, "")).c_str());  // the dated changes say all
  TEST_ASSERT_EQUAL_STRING(
      "over 8 sessions the calibration changes by a step before session 5: cam0.p_CI.x by 0.002 +- 0.0001 m. The "
      "result "
      "is a mean over the sessions, and its sigmas hold how far that is from the last one",
      course_words(changing({"steps"}, "steps")).c_str());
  TEST_ASSERT_EQUAL_STRING(
      "over 8 sessions the calibration changes steadily with time or with temperature (they do not tell which). If it "
      "is "
      "with temperature: cam0.p_CI.x by 0.002 +- 0.0001 m per degC. The result is a mean over the sessions, and its "
      "sigmas hold how far that is from each of them. --enable camera_temperature estimates that of the camera",
      course_words(changing({"trend", "temperature"}, "temperature")).c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_sure_entries_are_named_in_order_of_sigmas);
  RUN_TEST(test_where_no_entry_is_sure_the_words_say_so);
  RUN_TEST(test_a_change_within_a_session_has_a_time);
  RUN_TEST(test_courses_are_told);
  return UNITY_END();
}
