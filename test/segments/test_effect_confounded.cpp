// What the catalogue says effects are confounded with (effect_catalogue.h), on the motions that it names: there the
// data cannot tell, and on a lively motion they can.
#include <memory>

#include "../support/cases.h"
#include "../support/synthetic_segments.h"
#include "calibration/prior.h"
#include "diagnosis/score_test.h"
#include "segments/elimination.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr int kTimeOffset = 0, kRollingShutter = 1, kGSensitivity = 4, kAccelNonlinearity = 6, kGyroTemperature = 7,
              kGyroLag = 9;

/// One segment of a motion; `move` and `turn` scale its two parts.
struct Motion {
  double move = 1, turn = 1;
  float warming = 0;  ///< degC over the segment
};

/// Largest sigma of an effect's parameters in units of the prior's, with theta (its prior included) and `free` unknown.
/// -1: it has no direction of its own at all.
double relative_sigma(const Motion& motion, int effect, int free = -1) {
  test::SyntheticOptions options;
  options.seed = 71;
  options.segments = 1;
  options.keyframes = 12;
  options.landmarks = 60;
  options.move = motion.move;
  options.turn = motion.turn;
  options.start_error = 0;
  options.device = 0;
  const test::SyntheticSession session(options);
  Segment<double>& segment = *session.segments[0];
  for (int k = 0; k < segment.n_keyframes; ++k)
    segment.warmth[k] = motion.warming * float(k) / float(segment.n_keyframes);
  CandidateTerms c;
  for (int e : {effect, free}) {
    for (int i = 0; e >= 0 && i < effect_entry(e).n; ++i) c.term[c.n++] = effect_term(e, i);
  }
  static SegmentEliminator<double> eliminator;
  eliminator.eliminate(segment, GuestLink<double>(), session.nominal, session.model, 0, &c);
  const int n_theta = session.nominal.columns(), n = n_theta + c.n;
  std::vector<double> data(packed_size(n + 1)), scratch(ScoreTest<double>::scratch_size(c.n));
  PackedTriangle<double> T(data.data(), n + 1);
  ThetaPrior<double> prior;
  prior.mean = session.nominal;
  default_prior_sigmas(session.nominal, prior.sigma);
  write_prior(prior, session.nominal, &T);
  for (int i = 0; i <= n; ++i) {
    std::vector<double> row(eliminator.wide_row(i), eliminator.wide_row(i) + n + 1);
    fold_rows(T, row.data(), 1, n + 1, 0, n + 1);
  }
  const int m = effect_entry(effect).n;
  const TermGroup own{0, m}, other{m, c.n - m};
  const EffectScore<double> score = ScoreTest<double>(T, n_theta, scratch.data()).of(own, &other, free < 0 ? 0 : 1);
  if (score.dof < m) return -1;
  double worst = 0;
  for (int i = 0; i < m; ++i) worst = std::max(worst, score.sigma(i, m) / effect_entry(effect).prior_sigma);
  return worst;
}

/// The camera and the gyroscope alone cannot tell which of them is late.
void test_time_offset_and_gyro_lag() {
  const Motion turning{0, 1};
  const double alone = relative_sigma(turning, kTimeOffset), with_lag = relative_sigma(turning, kTimeOffset, kGyroLag);
  const double lively = relative_sigma({}, kTimeOffset), lively_with_lag = relative_sigma({}, kTimeOffset, kGyroLag);
  // Turning in place hides ten times what accelerated motion hides.
  test::check_between(Id().add("motion", "rotation"), "sigma with lag / alone", 10 * lively_with_lag / lively,
                      with_lag / alone, 1e9);
}

void test_g_sensitivity_needs_changing_force() {
  const double lively = relative_sigma({}, kGSensitivity), quiet = relative_sigma({0.01, 0.01}, kGSensitivity);
  test::check_between(Id().add("motion", "quiet"), "quiet or unseen", 10, quiet < 0 ? 1e9 : quiet / lively, 1e10);
}

void test_accel_nonlinearity_needs_attitudes() {
  const double lively = relative_sigma({}, kAccelNonlinearity),
               level = relative_sigma({0.05, 0.02}, kAccelNonlinearity);
  test::check_between(Id().add("motion", "level"), "sigma", 10, level < 0 ? 1e9 : level / lively, 1e10);
}

void test_rolling_shutter_needs_image_motion() {
  const double lively = relative_sigma({}, kRollingShutter), quiet = relative_sigma({0.02, 0.02}, kRollingShutter);
  test::check_between(Id().add("motion", "quiet"), "sigma", 10, quiet < 0 ? 1e9 : quiet / lively, 1e10);
}

/// Without a change of temperature there is no column; within one segment the bias takes most of a slow one.
void test_temperature_needs_change() {
  TEST_ASSERT_EQUAL_DOUBLE(-1, relative_sigma({}, kGyroTemperature));
  const double slow = relative_sigma({1, 1, 0.1f}, kGyroTemperature),
               fast = relative_sigma({1, 1, 2}, kGyroTemperature);
  test::check_between(Id().add("motion", "warming"), "sigma of a slow over a fast change", 10, slow / fast, 30);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_time_offset_and_gyro_lag);
  RUN_TEST(test_g_sensitivity_needs_changing_force);
  RUN_TEST(test_accel_nonlinearity_needs_attitudes);
  RUN_TEST(test_rolling_shutter_needs_image_motion);
  RUN_TEST(test_temperature_needs_change);
  return UNITY_END();
}
