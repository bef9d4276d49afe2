// The calibrator on simulated segments: truth comes back, sigmas are honest, float equals double, what was not excited
// stays where it was, and joins add information.
#include <Eigen/LU>
#include <memory>

#include "../support/cases.h"
#include "../support/cast.h"
#include "../support/synthetic_segments.h"
#include "calibration/calibrator.h"

using namespace SEGCAL_NS;
using test::Id;
using test::SyntheticOptions;
using test::SyntheticSession;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// What came out, in double.
struct Outcome {
  CalibrationFit<double> fit;
  Calibration<double> theta;
  Eigen::VectorXd sigma, prior_sigma;
  double gauge_moved = 0;  ///< m, the keyframe that holds the gauge
};

template <class S>
struct Solver {
  Calibrator<S> calibrator;
  SegmentEliminator<S> eliminator;
};

template <class S>
CalibrationFit<double> to_double(const CalibrationFit<S>& a) {
  return {a.converged,    a.iterations,   a.image_points, double(a.start_cost),
          double(a.cost), double(a.chi2), double(a.dof)};
}

/// Sigma of each parameter from the triangle R over [theta | rhs].
template <class S>
Eigen::VectorXd sigmas(const PackedTriangle<S>& T) {
  const int n = T.columns() - 1;
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    for (int c = i; c < n; ++c) R(i, c) = double(T(i, c));
  }
  return R.inverse().rowwise().norm();
}

/// Calibrates copies of the session's segments from nominal.
template <class S>
Outcome calibrate(const SyntheticSession& session, const CalibratorOptions& options = CalibratorOptions()) {
  static Solver<S> solver;
  test::Copies<S> copies(session.segments);
  ThetaPrior<S> prior;
  prior.mean = test::cast<S>(session.nominal);
  default_prior_sigmas(prior.mean, prior.sigma);
  solver.calibrator.begin(copies.pointer, copies.count(), prior, prior.mean, MeasurementModel<S>());
  const Vec3<S> start = copies.owned.front()->states.x[0].p_GI;
  solver.calibrator.run(options, &solver.eliminator);
  Outcome out;
  out.fit = to_double(solver.calibrator.fit());
  out.theta = test::cast<double>(solver.calibrator.theta());
  out.gauge_moved = static_cast<double>((copies.owned.front()->states.x[0].p_GI - start).norm());
  out.sigma = sigmas(solver.calibrator.theta_triangle());
  out.prior_sigma =
      Eigen::Map<Eigen::Matrix<S, Eigen::Dynamic, 1>>(prior.sigma, out.sigma.size()).template cast<double>();
  return out;
}

Eigen::VectorXd minus(const Calibration<double>& a, const Calibration<double>& b) {
  Eigen::VectorXd d(a.columns());
  difference(b, a, d.data());
  return d;
}

SyntheticOptions device(std::uint32_t seed, Distortion model = Distortion::fov) {
  SyntheticOptions options;
  options.seed = seed;
  options.model = model;
  options.segments = 3;
  options.keyframes = 16;
  options.landmarks = 60;
  options.gap = seed % 2 ? 0 : 2;
  return options;
}

void check_fit(const Id& id, const Outcome& out) {
  test::check_true(id, "did not converge", out.fit.converged);
  test::check_true(id, "the cost did not fall", out.fit.cost < out.fit.start_cost);
  // chi2 of d degrees of freedom has sigma sqrt(2 d): five of those.
  const double spread = 5 * std::sqrt(2 / out.fit.dof);
  test::check_between(id, "chi2/dof", 1 - spread, out.fit.chi2 / out.fit.dof, 1 + spread);
}

constexpr int kDevices = 12;

void test_errors_match_sigmas() {
  Eigen::VectorXd squares;
  double chi2 = 0;
  for (int seed = 1; seed <= kDevices; ++seed) {
    const SyntheticSession session(device(60 + seed));
    const Outcome out = calibrate<float>(session);
    const Id id = Id().add("check", "devices").add("seed", seed);
    check_fit(id, out);
    const Eigen::VectorXd normalised = minus(out.theta, session.truth).cwiseQuotient(out.sigma);
    for (int i = 0; i < normalised.size(); ++i)
      test::check_near(id.add("column", i), "error in sigmas", 0, normalised(i), 5);
    squares = squares.size() ? squares + normalised.cwiseAbs2() : normalised.cwiseAbs2().eval();
    chi2 += out.fit.chi2 / out.fit.dof / kDevices;
  }
  test::check_between(Id().add("check", "mean_chi2"), "chi2/dof", 0.95, chi2, 1.05);
  // The mean of 12 squared normal numbers lies in 0.18..2.9 with
  // a probability of 0.999, here for each of 26 parameters.
  for (int i = 0; i < squares.size(); ++i) {
    test::check_between(Id().add("check", "honest").add("column", i), "mean squared error", 0.18, squares(i) / kDevices,
                        2.9);
  }
  // All parameters of all devices together, as 200 independent
  // numbers (they are correlated): sigma 0.1, three of those.
  test::check_between(Id().add("check", "honest_overall"), "mean squared error", 0.7, squares.mean() / kDevices, 1.3);
}

void test_other_camera_models() {
  for (Distortion model : {Distortion::radtan, Distortion::equidistant}) {
    const SyntheticSession session(device(81, model));
    const Outcome out = calibrate<float>(session);
    const Id id = Id().add("check", "model").add("model", int(model));
    check_fit(id, out);
    const Eigen::VectorXd normalised = minus(out.theta, session.truth).cwiseQuotient(out.sigma);
    for (int i = 0; i < normalised.size(); ++i)
      test::check_near(id.add("column", i), "error in sigmas", 0, normalised(i), 5);
  }
}

void test_far_start() {
  // Twice the usual deviations of the device, states that begin 1 degree, 6 cm and 0.2 m/s off.
  for (std::uint32_t seed : {91u, 92u, 93u}) {
    SyntheticOptions options = device(seed);
    options.device = 2;
    options.start_error = 6;
    const SyntheticSession session(options);
    const Outcome out = calibrate<float>(session);
    const Id id = Id().add("check", "far").add("seed", seed);
    check_fit(id, out);
    const Eigen::VectorXd normalised = minus(out.theta, session.truth).cwiseQuotient(out.sigma);
    for (int i = 0; i < normalised.size(); ++i)
      test::check_near(id.add("column", i), "error in sigmas", 0, normalised(i), 5);
  }
}

/// Above a floor, 12 to 25 cm away: priors that count from fixed anchors would pull the world away from them, and only
/// the gauge would hold it. A fit that creeps does not settle.
void test_near_landmarks_do_not_drive_the_world_away() {
  for (std::uint32_t seed : {94u, 95u, 96u}) {
    SyntheticOptions options = device(seed);
    options.nearest = 0.12;
    options.farthest = 0.25;
    options.move = 0.1;
    const SyntheticSession session(options);
    const Outcome out = calibrate<float>(session);
    const Id id = Id().add("check", "near").add("seed", seed);
    test::check_true(id, "did not converge", out.fit.converged);
    test::check_between(id, "iterations", 1, out.fit.iterations, 10);
    // Nothing pulls; from fixed anchors a pull of 2400 over the square of the hold
    // would move it by 0.2 um with each iteration. Float rounds a metre to 0.1 um.
    test::check_near(id, "the first keyframe moved, m", 0, out.gauge_moved, 1e-5);
  }
}

void test_float_equals_double() {
  for (std::uint32_t seed : {61u, 62u}) {
    const SyntheticSession session(device(seed));
    const Outcome f = calibrate<float>(session), d = calibrate<double>(session);
    const Id id = Id().add("check", "float").add("seed", seed);
    const Eigen::VectorXd offset = minus(f.theta, d.theta).cwiseQuotient(d.sigma);
    // Both stop within 0.03 sigma of the minimum.
    for (int i = 0; i < offset.size(); ++i) {
      test::check_near(id.add("column", i), "difference in sigmas", 0, offset(i), 0.05);
      test::check_near(id.add("column", i), "ratio of sigmas", 1, f.sigma(i) / d.sigma(i), 0.01);
    }
    test::check_near(id, "chi2", d.fit.chi2, f.fit.chi2, 0.01 * d.fit.chi2);
    TEST_ASSERT_EQUAL_INT(d.fit.dof, f.fit.dof);
  }
}

/// Corner tracks: every third point is off by 3 px more than
/// its noise, so that robust weights change at each iteration.
void add_tails(std::uint32_t seed, SyntheticSession* session) {
  test::Random random(seed);
  for (auto& segment : session->segments) {
    for (int o = 0; o < segment->n_observations; ++o) {
      if (random.uniform(0, 1) > 0.33) continue;
      segment->observation[o].u = float(segment->observation[o].u) + float(random.normal(3));
      segment->observation[o].v = float(segment->observation[o].v) + float(random.normal(3));
    }
  }
}

/// Cut off at each iteration in turn. While the cost falls the fit has not converged; where it is flat, a last step of
/// less than half a sigma counts, and theta is that near to the minimum. Without `swings` the same fits are refused.
void test_last_step_on_a_flat_cost() {
  SyntheticSession session(device(74));
  add_tails(74, &session);
  const Outcome settled = calibrate<double>(session);
  int counted = 0;
  for (int n = 1; n < settled.fit.iterations; ++n) {
    CalibratorOptions options, strict;
    options.max_iterations = strict.max_iterations = n;
    strict.swings = 0;
    const Outcome cut = calibrate<double>(session, options), refused = calibrate<double>(session, strict);
    const Id id = Id().add("check", "last_step").add("iterations", n);
    TEST_ASSERT_EQUAL_INT(n, cut.fit.iterations);
    const double away = minus(cut.theta, settled.theta).cwiseQuotient(settled.sigma).norm();
    test::check_true(id, "converged although sigmas off", away < 1 || !cut.fit.converged);
    if (!cut.fit.converged) continue;
    counted += refused.fit.converged ? 0 : 1;
    test::check_between(id, "distance from the minimum in sigmas", 0, away, 0.5);
  }
  test::check_between(Id().add("check", "last_step"), "iterations that only `swings` accepts", 1, counted, 30);
}

void test_no_motion_leaves_the_prior() {
  SyntheticOptions options = device(71);
  options.move = options.turn = 0;
  const SyntheticSession session(options);
  const Outcome out = calibrate<float>(session);
  const Eigen::VectorXd moved = minus(out.theta, session.nominal).cwiseQuotient(out.prior_sigma);
  const Eigen::VectorXd known = out.sigma.cwiseQuotient(out.prior_sigma);
  const Id id = Id().add("check", "still");
  for (int i = 0; i < moved.size(); ++i) {
    // Image points at rest only fix their landmarks' directions, and the IMU its biases and the direction of gravity.
    // Gravity ties the vertical accelerometer's bias (prior 1 m/s^2) to its scale (0.05 g = 0.49 m/s^2), which leaves
    // 1 / sqrt(1 + 0.49^2) = 0.898 of the scale's sigma, and less than that of nothing.
    test::check_between(id.add("column", i), "sigma over prior sigma", 0.88, known(i), 1.0001);
    test::check_near(id.add("column", i), "moved, in prior sigmas", 0, moved(i), 1);
  }
  test::check_between(id, "chi2/dof", 0, out.fit.chi2 / out.fit.dof, 1.2);
}

void test_rotation_in_place_says_nothing_of_the_lever_arm() {
  // No translation of the IMU: parallax is the lever arm's alone (5 cm), so p_CI and scale stay nearly unknown.
  SyntheticOptions options = device(72);
  options.move = 0;
  const SyntheticSession session(options);
  const Outcome out = calibrate<float>(session);
  const Id id = Id().add("check", "in_place");
  check_fit(id, out);
  const Eigen::VectorXd normalised = minus(out.theta, session.truth).cwiseQuotient(out.sigma);
  for (int i = 0; i < normalised.size(); ++i)
    test::check_near(id.add("column", i), "error in sigmas", 0, normalised(i), 5);
  // Along the lever arm itself the prior's sigma stays: the sum of the components' sigmas there is at least that of the
  // direction (triangle inequality), less the tenth that noise may feign.
  const Vec3<double> along = session.nominal.camera[0].p_CI.normalized().cwiseAbs();
  double sigma = 0;
  for (int i = 0; i < 3; ++i) sigma += along(i) * out.sigma(3 + i);
  test::check_between(id, "sigma along the lever arm over the prior's", 0.75, sigma / out.prior_sigma(3), 2);
}

void test_joins_add_information() {
  SyntheticSession joined(device(73));
  SyntheticSession apart(device(73));
  for (std::size_t s = 0; s < apart.segments.size(); ++s) apart.segments[s]->session = static_cast<std::uint32_t>(s);
  const Outcome a = calibrate<float>(joined), b = calibrate<float>(apart);
  const Id id = Id().add("check", "joins");
  check_fit(id.add("which", "joined"), a);
  check_fit(id.add("which", "apart"), b);
  for (int i = 0; i < a.sigma.size(); ++i) {
    // Sigmas are taken at slightly different minima: one per cent.
    test::check_between(id.add("column", i), "joined over apart", 0, a.sigma(i) / b.sigma(i), 1.01);
  }
  // Biases known from segment to segment: the sensors' scales must gain.
  test::check_between(id, "best gain", 0, a.sigma.cwiseQuotient(b.sigma).minCoeff(), 0.97);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_errors_match_sigmas);
  RUN_TEST(test_other_camera_models);
  RUN_TEST(test_far_start);
  RUN_TEST(test_near_landmarks_do_not_drive_the_world_away);
  RUN_TEST(test_float_equals_double);
  RUN_TEST(test_last_step_on_a_flat_cost);
  RUN_TEST(test_no_motion_leaves_the_prior);
  RUN_TEST(test_rotation_in_place_says_nothing_of_the_lever_arm);
  RUN_TEST(test_joins_add_information);
  return UNITY_END();
}
