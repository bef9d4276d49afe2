// One table for all that may be missing: nothing of the core's catalogue is left out of it, and it contradicts nothing.
#include <cmath>
#include <set>
#include <string>

#include "../support/cases.h"
#include "diagnose/fit_rows.h"
#include "diagnose/hypotheses.h"
#include "diagnose/model_terms.h"
#include "sensors/effect_catalogue.h"

using namespace host::diagnosis;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

bool follows_temperature(const SEGCAL_NS::Term& t) {
  return t.of_warm_camera() || (t.of_imu() && t.a == static_cast<int>(SEGCAL_NS::Signal::warmth));
}

void test_each_effect_of_the_core_has_one_row() {
  int rows = 0;
  for (const Hypothesis& h : hypotheses()) rows += h.kind == Kind::effect;
  TEST_ASSERT_EQUAL_INT(SEGCAL_NS::kEffects, rows);
  for (int e = 0; e < SEGCAL_NS::kEffects; ++e) {
    const SEGCAL_NS::EffectEntry& entry = SEGCAL_NS::effect_entry(e);
    const Hypothesis& h = hypothesis(entry.name);
    TEST_ASSERT_TRUE_MESSAGE(h.kind == Kind::effect, entry.name);
    TEST_ASSERT_EQUAL_DOUBLE(entry.prior_sigma, h.size);
    TEST_ASSERT_EQUAL_MESSAGE(follows_temperature(SEGCAL_NS::effect_term(e, 0)), h.asks == Asks::temperature,
                              entry.name);
  }
}

/// A column of the gyroscope is about the gyroscope. What moves stamps is about them, whichever column says so.
void test_rows_are_about_what_their_columns_move() {
  for (int e = 0; e < SEGCAL_NS::kEffects; ++e) {
    const SEGCAL_NS::Term t = SEGCAL_NS::effect_term(e, 0);
    const unsigned about = hypothesis(SEGCAL_NS::effect_entry(e).name).about;
    if ((about & of_timing) != 0) continue;
    const bool late = t.kind == SEGCAL_NS::TermKind::gyro_lag, offset = t.kind == SEGCAL_NS::TermKind::axis_offset;
    const unsigned column = t.of_gyro() || late ? of_gyro : (t.of_imu() && !t.of_gyro()) || offset ? of_accel : of_lens;
    TEST_ASSERT_EQUAL_UINT_MESSAGE(column, about, SEGCAL_NS::effect_entry(e).name);
  }
}

/// With nothing there, no name has a larger probability than the level: the shares of all that is asked add up to one
/// at most.
void test_shares_add_up_to_one() {
  for (const bool exposures : {false, true}) {
    double sum = share_of(Kind::step) + share_of(Kind::term);  // each over the number of its trials
    for (const Hypothesis& h : hypotheses()) {
      if (h.kind == Kind::effect || (h.kind == Kind::exposure && exposures)) sum += share_of(h.kind, exposures);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1, sum);  // 0.9 + 0.09 + 0.01
  }
}

void test_every_row_has_words() {
  std::set<std::string> names;
  for (const Hypothesis& h : hypotheses()) {
    TEST_ASSERT_TRUE_MESSAGE(names.insert(h.name).second, h.name);
    TEST_ASSERT_GREATER_THAN(10, std::string(h.looks_like).size());
    TEST_ASSERT_GREATER_THAN(10, std::string(h.needs).size());
  }
  TEST_ASSERT_EQUAL_STRING(hypothesis("gyro_lag").needs, needs("gyro_lag").c_str());
  TEST_ASSERT_EQUAL_STRING(separates("gyro_lag", "time_offset").c_str(), separates("time_offset", "gyro_lag").c_str());
  TEST_ASSERT_TRUE(separates("gyro_lag", "time_offset").find("accelerations without turns") == 0);
  TEST_ASSERT_TRUE(separates("gyro_lag", "radial_residual").find("; ") != std::string::npos);  // what each needs
}

/// Theta has as many entries as its blocks, and each block a size and a unit.
void test_steps_cover_theta() {
  host::Calibration calibration;
  calibration.cameras.resize(2);
  calibration.cameras[0].model = host::DistortionModel::fov;
  calibration.cameras[1].model = host::DistortionModel::radtan;
  int next = 0;
  for (const Block& b : blocks_of(calibration)) {
    TEST_ASSERT_EQUAL_INT(next, b.columns.first);
    TEST_ASSERT_EQUAL_DOUBLE(step_size(b.name).size, b.size.front());
    next += b.columns.count;
  }
  TEST_ASSERT_EQUAL_INT(11 + 14 + 15, next);
  TEST_ASSERT_EQUAL_STRING("px", step_size("cam1.f").unit);
  TEST_ASSERT_EQUAL_STRING("rad", step_size("accel.r_AI").unit);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_each_effect_of_the_core_has_one_row);
  RUN_TEST(test_rows_are_about_what_their_columns_move);
  RUN_TEST(test_shares_add_up_to_one);
  RUN_TEST(test_every_row_has_words);
  RUN_TEST(test_steps_cover_theta);
  return UNITY_END();
}
