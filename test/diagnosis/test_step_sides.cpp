// A large step of the calibration: each side of it linearised at its own theta.
#include <algorithm>
#include <cmath>
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

/// chi2 of the best fit with the step, over its degrees of freedom, and the step.
struct Stepped {
  double excess = 0;
  EffectTest step;
};
Stepped fit_of(const Problem& with, const Shift& shift, const std::vector<TermGroup>& free = {}) {
  const Candidate candidate = shift_candidate(with, shift);
  std::vector<TermGroup> groups = free;
  groups.push_back(candidate.columns);
  const Rows rows = with_groups(with_prior(with.all, with.prior), with.n_theta, groups);
  return {solve(rows).cost - rows.dof, test_effect(with, candidate, free)};
}

/// The largest distance of an entry from what was put in, in sigmas.
double off(const EffectTest& step) {
  double out = 0;
  for (int i = 0; i < 3; ++i) out = std::max(out, std::abs(step.value(i) - kLargeStep(i)) / step.sigma(i));
  return out;
}

/// What is curved in 56 mrad is gone from the residuals, and the step is where it was put.
void test_each_side_has_its_own_rows() {
  Fitted fit(bent(kLarge), "mobile");
  std::optional<Shift> shift = best_shift(fit.problem, {});
  TEST_ASSERT_TRUE(shift.has_value());
  TEST_ASSERT_EQUAL_STRING("cam0.r_CI", shift->block.name.c_str());
  TEST_ASSERT_TRUE(shift->straddling >= 0);
  const Stepped flat = fit_of(with_shift(fit.problem, *shift), *shift);
  const Stepped own = fit_of(stepped(fit.problem, {}, fit.at_step(), &*shift), *shift);
  std::printf("chi2 - dof %.1f linearised between both sides, %.1f at their own; the step %.1f and %.1f sigma off\n",
              flat.excess, own.excess, off(flat.step), off(own.step));
  TEST_ASSERT_TRUE(own.excess < flat.excess - 25);  // five sigmas of what one direction may take
  TEST_ASSERT_TRUE(off(own.step) < 3);
}

/// With an effect in the fit, whose value counts from zero as before; made twice, it is the same.
void test_an_effect_beside_the_step() {
  Fitted fit(bent(kLarge), "mobile");
  std::vector<int> offset;
  for (std::size_t c = 0; c < fit.model.candidates.size(); ++c) {
    if (fit.model.candidates[c].name == "time_offset") offset = {static_cast<int>(c)};
  }
  const Candidate time_offset = fit.model.candidates[static_cast<std::size_t>(offset.at(0))];
  const Problem with_offset = fit.evidence.fit(fit.model.terms, fit.model.columns_of(offset), fit.model.start);
  std::optional<Shift> shift = best_shift(with_offset, {time_offset.columns});
  TEST_ASSERT_TRUE(shift.has_value());
  const Problem once = stepped(with_offset, {time_offset.columns}, fit.at_step(), &*shift),
                again = stepped(with_offset, {time_offset.columns}, fit.at_step(), &*shift);
  TEST_ASSERT_TRUE(once.all.R == again.all.R);
  TEST_ASSERT_TRUE(off(fit_of(once, *shift, {time_offset.columns}).step) < 3);
  const EffectTest none = test_effect(once, time_offset, {shift_candidate(once, *shift).columns});
  TEST_ASSERT_DOUBLE_WITHIN(4 * none.sigma(0), 0, none.value(0));
}

/// The next fit is one for all again, and so are its rows.
void test_the_next_fit_forgets_the_sides() {
  Fitted fit(bent(kLarge), "mobile");
  std::optional<Shift> shift = best_shift(fit.problem, {});
  TEST_ASSERT_TRUE(shift.has_value());
  const Problem before = fit.problem;
  stepped(fit.problem, {}, fit.at_step(), &*shift);
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
  RUN_TEST(test_an_effect_beside_the_step);
  RUN_TEST(test_the_next_fit_forgets_the_sides);
  RUN_TEST(test_a_large_step_has_its_name);
  return UNITY_END();
}
