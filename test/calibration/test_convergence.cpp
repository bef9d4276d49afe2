// When a fit is at its end: what a damped step gains does not tell, and a path mirrored with its map is none.
#include <memory>

#include "../support/cases.h"
#include "../support/synthetic_segments.h"
#include "calibration/calibrator.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

void test_a_damped_step_is_not_the_end() {
  const CalibratorOptions options;
  const double step[1] = {1e-3}, sigma[1] = {1};
  StepPolicy<double> policy;
  policy.begin(1000);
  // Along a curved valley: the whole step should gain five and costs, the damped one gains next to nothing.
  TEST_ASSERT_FALSE(policy.judge(1100, 5, step, 1, sigma, options));
  TEST_ASSERT_TRUE(policy.damping() > 0);
  TEST_ASSERT_FALSE(policy.judge(1000 - 1e-5, 1e-5, step, 1, sigma, options));
  TEST_ASSERT_TRUE(policy.kept());
  TEST_ASSERT_FALSE(policy.converged(5, options));
  // Damped again and of no use: no rounding has been met.
  TEST_ASSERT_FALSE(policy.judge(1100, 5, step, 1, sigma, options));
  TEST_ASSERT_FALSE(policy.judge(1000, 1e-5, step, 1, sigma, options));
  TEST_ASSERT_FALSE(policy.converged(5, options));
}

void test_a_whole_step_that_gains_nothing_is_the_end() {
  const CalibratorOptions options;
  const double step[1] = {1e-3}, sigma[1] = {1};
  StepPolicy<double> policy;
  policy.begin(1000);
  TEST_ASSERT_TRUE(policy.judge(1000 - 1e-5, 1e-5, step, 1, sigma, options));
  TEST_ASSERT_TRUE(policy.converged(1e-5, options));
  policy.begin(1000);
  TEST_ASSERT_TRUE(policy.judge(1000.1, 1e-5, step, 1, sigma, options));  // rounding
  TEST_ASSERT_TRUE(policy.converged(1e-5, options));
}

/// Damping is for steps that swing, which gain something each time; rounding turns steps back as well.
void test_only_steps_that_gain_are_damped() {
  const CalibratorOptions options;
  const double there[1] = {1}, back[1] = {-1}, sigma[1] = {1};
  for (const double fall : {0.5 * options.converged, 2 * options.converged}) {
    StepPolicy<double> policy;
    policy.begin(1000);
    policy.judge(900, 100, there, 1, sigma, options);
    TEST_ASSERT_TRUE(policy.damping() == 0);
    policy.judge(900 - fall, fall, back, 1, sigma, options);
    TEST_ASSERT_EQUAL(fall > options.converged, policy.damping() > 0);
  }
  // A damped one should gain little wherever it is: it swings all the same.
  StepPolicy<double> policy;
  policy.begin(1000);
  TEST_ASSERT_FALSE(policy.judge(1100, 5, there, 1, sigma, options));
  TEST_ASSERT_FALSE(policy.judge(990, 1e-3, there, 1, sigma, options));
  const double damping = policy.damping();
  TEST_ASSERT_FALSE(policy.judge(980, 1e-3, back, 1, sigma, options));
  TEST_ASSERT_TRUE(damping > 0 && policy.damping() > damping);
}

/// In float the cost of 3000 is known to 0.006: a damped step that should gain less is no reason to damp more.
void test_rounding_is_no_reason_to_damp() {
  const CalibratorOptions options;
  const float there[1] = {1}, back[1] = {-1}, sigma[1] = {1};
  for (const float trial : {3000.02f, 3000.0f}) {
    StepPolicy<float> policy;
    policy.begin(3010);
    TEST_ASSERT_FALSE(policy.judge(3000.04f, 20, there, 1, sigma, options));
    TEST_ASSERT_FALSE(policy.judge(3000.0f, 0.04f, back, 1, sigma, options));
    TEST_ASSERT_TRUE(policy.damping() > 0);
    TEST_ASSERT_FALSE(policy.judge(trial, 5e-4f, there, 1, sigma, options));
    TEST_ASSERT_TRUE(policy.damping() == 0);
    TEST_ASSERT_TRUE(policy.judge(3000.02f, 3e-5f, there, 1, sigma, options));
    TEST_ASSERT_TRUE(policy.converged(3e-5f, options));
  }
}

/// A cost with a kink: the whole step should gain 0.03 and costs, the damped one should gain less than rounding.
void test_no_step_is_asked_for_ever() {
  const CalibratorOptions options;
  const float step[1] = {1}, sigma[1] = {1};
  StepPolicy<float> policy;
  policy.begin(3000);
  TEST_ASSERT_FALSE(policy.judge(3001, 0.03f, step, 1, sigma, options));
  TEST_ASSERT_TRUE(policy.judge(3000.02f, 1e-3f, step, 1, sigma, options));
  // A damped step that is kept leads elsewhere, and landmarks may gain there what the linear system does not tell: a
  // whole step from there is asked again.
  for (const float kept : {2900.0f, 3000.0f}) {
    policy.begin(3000);
    TEST_ASSERT_FALSE(policy.judge(3001, 0.03f, step, 1, sigma, options));
    TEST_ASSERT_FALSE(policy.judge(kept, 1e-3f, step, 1, sigma, options));
    TEST_ASSERT_TRUE(policy.kept() && policy.damping() == 0);
    TEST_ASSERT_FALSE(policy.judge(kept + 1, 0.03f, step, 1, sigma, options));
    TEST_ASSERT_TRUE(policy.damping() > 0);
  }
  // Where that happens twice in a row, it would go on so to the last iteration.
  policy.begin(3000);
  for (const bool second : {false, true}) {
    TEST_ASSERT_FALSE(policy.judge(3040, 0.17f, step, 1, sigma, options));
    TEST_ASSERT_EQUAL(second, policy.judge(2999, 1e-3f, step, 1, sigma, options));
  }
  TEST_ASSERT_TRUE(policy.converged(0.17f, options));
  // Not where theta moves, nor where a whole step says that it should. Rounding is 0.02 here: after a step that should
  // gain less the next one is a whole one.
  const float moves[2][2] = {{0.17f, 0.01f}, {0.3f, 1e-3f}};
  for (const float* m : moves) {
    policy.begin(10000);
    for (int i = 0; i < 4; ++i) {
      TEST_ASSERT_TRUE(policy.damping() == 0);
      TEST_ASSERT_FALSE(policy.judge(10040, m[0], step, 1, sigma, options));
      TEST_ASSERT_FALSE(policy.judge(9999, m[1], step, 1, sigma, options));
    }
  }
  // It was from another place that a whole step was refused.
  policy.begin(3000);
  TEST_ASSERT_FALSE(policy.judge(3001, 0.03f, step, 1, sigma, options));
  TEST_ASSERT_FALSE(policy.judge(2990, 0.02f, step, 1, sigma, options));
  TEST_ASSERT_TRUE(policy.damping() > 0);
  TEST_ASSERT_FALSE(policy.judge(2990.1f, 1e-3f, step, 1, sigma, options));
  TEST_ASSERT_TRUE(policy.damping() == 0);
}

/// As if the first steps had been taken the wrong way: two hundredths of the path with the other sign, and landmarks at
/// infinity. With all of it mirrored, landmarks behind the camera, images are the same but for the lever arm's part.
void start_the_wrong_way(Segment<double>* segment) {
  const Vec3<double> start = segment->states.x[0].p_GI;
  for (int k = 0; k < segment->n_keyframes; ++k) {
    State<double>& x = segment->states.x[k];
    x.p_GI = start - 0.02 * (x.p_GI - start);
    x.v_GI *= -0.02;
  }
  for (int j = 0; j < segment->n_landmarks; ++j) {
    Landmark<double>& l = segment->states.landmark[j];
    l.o = start + (l.o - start) * 0.02;
    l.rho = 0;
  }
}

int behind(const Segment<double>& segment) {
  int n = 0;
  for (int j = 0; j < segment.n_landmarks; ++j) n += segment.states.landmark[j].rho < -0.15 ? 1 : 0;
  return n;
}

/// With an IMU that hardly says where the device went.
void test_no_landmark_goes_behind_the_camera() {
  static Calibrator<double> calibrator;
  static SegmentEliminator<double> eliminator;
  test::SyntheticOptions session_options;
  session_options.segments = 1;
  session_options.keyframes = 16;
  session_options.landmarks = 60;
  session_options.device = 0;
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    session_options.seed = seed;
    const test::SyntheticSession session(session_options);
    MeasurementModel<double> model;
    model.imu.accel = 2;  // m/s^2/sqrt(Hz), a thousand times the usual
    ThetaPrior<double> prior;
    prior.mean = session.nominal;
    default_prior_sigmas(prior.mean, prior.sigma);
    auto segment = std::make_unique<Segment<double>>(*session.segments[0]);
    start_the_wrong_way(segment.get());
    const Id id = Id().add("check", "wrong_way").add("seed", static_cast<int>(seed));
    Segment<double>* pointer[] = {segment.get()};
    calibrator.begin(pointer, 1, prior, prior.mean, model);
    CalibratorOptions options;
    options.max_iterations = 60;
    calibrator.run(options, &eliminator);
    test::check_between(id, "landmarks behind the camera", 0, behind(*segment), 0);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_a_damped_step_is_not_the_end);
  RUN_TEST(test_a_whole_step_that_gains_nothing_is_the_end);
  RUN_TEST(test_only_steps_that_gain_are_damped);
  RUN_TEST(test_rounding_is_no_reason_to_damp);
  RUN_TEST(test_no_step_is_asked_for_ever);
  RUN_TEST(test_no_landmark_goes_behind_the_camera);
  return UNITY_END();
}
