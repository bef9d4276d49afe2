// What a diagnosis concludes of faults beside fits: gravity that is a little off may be an effect of the accelerometer.
#include <unity.h>

#include "diagnose/answer.h"
#include "diagnose/diagnose.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using host::Diagnosis;

/// A device at rest whose specific force has this size, with or without an effect that fits found.
Diagnosis concluded(double gravity, const char* effect, bool accepted = false) {
  Diagnosis d;
  d.judged = true;
  d.faults_accepted = accepted;
  host::Fault fault;
  fault.kind = "gravity_norm";
  fault.sensor = "accel";
  fault.value = gravity;
  fault.words = "the specific force is off.";
  d.faults = {fault};
  d.before.total = 1;
  if (effect) {
    host::DiagnosedEffect found;
    found.name = effect;
    d.effects = {found};
  }
  host::diagnosis::conclude(&d);
  return d;
}

bool speaks_of_data(const Diagnosis& d) { return d.sentence.find("The data are at fault") != std::string::npos; }

void test_an_effect_of_the_accelerometer_explains_it() {
  const Diagnosis d = concluded(10.5, "accel_temperature");
  TEST_ASSERT_EQUAL_STRING("explained", d.verdict.c_str());
  TEST_ASSERT_FALSE(speaks_of_data(d));
}

void test_without_one_it_is_the_data() {
  TEST_ASSERT_EQUAL_STRING("bad_data", concluded(10.5, nullptr).verdict.c_str());
  const Diagnosis other = concluded(9.2, "time_offset");
  TEST_ASSERT_EQUAL_STRING("explained", other.verdict.c_str());
  TEST_ASSERT_TRUE(speaks_of_data(other));
  TEST_ASSERT_TRUE(speaks_of_data(concluded(9.2, "accel_axis_offset")));  // which does nothing at rest
  TEST_ASSERT_TRUE(speaks_of_data(concluded(10.5, nullptr, true)));
}

/// A range that is set to half of what is said: no fit is asked.
void test_a_factor_is_the_data_whatever_was_found() {
  TEST_ASSERT_EQUAL_STRING("bad_data", concluded(19.6, "accel_temperature").verdict.c_str());
  TEST_ASSERT_EQUAL_STRING("bad_data", concluded(8.7, "accel_temperature").verdict.c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_an_effect_of_the_accelerometer_explains_it);
  RUN_TEST(test_without_one_it_is_the_data);
  RUN_TEST(test_a_factor_is_the_data_whatever_was_found);
  return UNITY_END();
}
