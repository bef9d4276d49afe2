// A large step of the calibration: each side of it linearised at its own theta.
#include <cstdio>
#include <string>

#include "../support/cases.h"
#include "diagnose/diagnose.h"
#include "diagnose/evidence.h"
#include "diagnose/searched_model.h"
#include "diagnose/shift.h"
#include "simulate/effect_names.h"
#include "simulate/simulate.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace host::diagnosis;
using Eigen::VectorXd;

/// A minute of gentle motion; the mount bends in its middle.
host::SimulationResult bent(const std::string& rad) {
  host::SimulationOptions options;
  options.scenario = "nav";
  options.seconds = 60;
  options.seed = 170010073;
  options.effects.push_back(host::sim::parse_effect("calibration_shift=cam0.r_CI,30," + rad));
  return host::simulate(options);
}
constexpr const char* kLarge = "-0.05,0.024,0.006";
const Eigen::Vector3d kLargeStep(-0.05, 0.024, 0.006);

/// The fit without the step, and its rows.
struct Fitted {
  explicit Fitted(const host::SimulationResult& session, const std::string& profile)
      : sessions{session.recording},
        options(options_of(session)),
        model(options, false, false),
        evidence(sessions, without_effects(options, false), profile, &work, {}),
        problem(evidence.fit(model.terms, model.columns_of({}), model.start)) {}

  static host::CoreOptions options_of(const host::SimulationResult& session) {
    host::CoreOptions out;
    out.calibration = session.nominal;
    out.noise = session.recording.imu.noise;
    return out;
  }
  AtStep at_step() {
    return [this](const auto&... asked) { return evidence.at_step(asked...); };
  }

  std::vector<host::Recording> sessions;
  host::CoreOptions options;
  SearchedModel model;
  Budget work{decision::kSlices};
  Evidence evidence;
  Problem problem;
};

/// chi2 of the best fit with the step, and the step.
struct Stepped {
  double chi2 = 0;
  EffectTest step;
};
Stepped fit_of(const Problem& with, const Shift& shift) {
  const Candidate candidate = shift_candidate(with, shift);
  const Rows rows = with_groups(with_prior(with.all, with.prior), with.n_theta, {candidate.columns});
  return {solve(rows).cost, test_effect(with, candidate, {})};
}

/// What is curved in 56 mrad is gone from the residuals (110 of a chi2 of 11,600), and the step is where it was put, by
/// its own sigmas.
void test_each_side_has_its_own_rows() {
  Fitted fit(bent(kLarge), "mobile");
  const std::optional<Shift> shift = best_shift(fit.problem, {});
  TEST_ASSERT_TRUE(shift.has_value());
  TEST_ASSERT_EQUAL_STRING("cam0.r_CI", shift->block.name.c_str());
  const Stepped flat = fit_of(with_shift(fit.problem, *shift), *shift);
  const Problem with = stepped(fit.problem, *shift, {}, fit.at_step());
  const Stepped own = fit_of(with, *shift);
  std::printf("chi2 %.1f linearised between both sides, %.1f at their own\n", flat.chi2, own.chi2);
  TEST_ASSERT_TRUE(own.chi2 < flat.chi2 - 25);  // 5 sigma of what one of theta's directions may take
  for (int i = 0; i < 3; ++i) TEST_ASSERT_DOUBLE_WITHIN(4 * own.step.sigma(i), kLargeStep(i), own.step.value(i));
  const Stepped again = fit_of(stepped(fit.problem, *shift, {}, fit.at_step()), *shift);
  TEST_ASSERT_DOUBLE_WITHIN(1e-6 * own.chi2, own.chi2, again.chi2);
}

/// The next fit is one for all again, and so are its rows.
void test_the_next_fit_forgets_the_sides() {
  Fitted fit(bent(kLarge), "mobile");
  const std::optional<Shift> shift = best_shift(fit.problem, {});
  TEST_ASSERT_TRUE(shift.has_value());
  const Problem before = fit.problem;
  stepped(fit.problem, *shift, {}, fit.at_step());
  const Problem after = fit.evidence.fit(fit.model.terms, fit.model.columns_of({}), fit.model.start);
  TEST_ASSERT_TRUE(before.all.R == after.all.R);
}

/// 28 mrad: nothing else has a part in it.
void test_a_large_step_has_its_name() {
  const host::SimulationResult session = bent("-0.0251,0.0117,0.0031");
  host::DiagnoseOptions options;
  options.core = Fitted::options_of(session);
  const host::Diagnosis d = host::diagnose({session.recording}, options);
  TEST_ASSERT_EQUAL_STRING_MESSAGE("explained", d.verdict.c_str(), d.sentence.c_str());
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, static_cast<int>(d.effects.size()), d.sentence.c_str());
  TEST_ASSERT_EQUAL_STRING("calibration_shift", d.effects[0].name.c_str());
  TEST_ASSERT_TRUE_MESSAGE(d.gap_closed >= 0.9, d.sentence.c_str());
  TEST_ASSERT_TRUE(d.before.gyro > 5 * d.gap_sigma.gyro);  // images and gyroscope disagree about where turns go
  TEST_ASSERT_DOUBLE_WITHIN(3 * d.gap_sigma.gyro, 0, d.after.gyro);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_each_side_has_its_own_rows);
  RUN_TEST(test_the_next_fit_forgets_the_sides);
  RUN_TEST(test_a_large_step_has_its_name);
  return UNITY_END();
}
