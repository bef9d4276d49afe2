// The square-root elimination against a dense QR of the full stacked Jacobian: information, solution, marginal
// covariance, back-substitution; segments joined by an IMU link and by the bias walk over a gap; damping; float.
#include <Eigen/LU>
#include <memory>

#include "../support/cases.h"
#include "../support/cast.h"
#include "../support/dense_problem.h"
#include "../support/synthetic_segments.h"
#include "calibration/calibrator.h"

using namespace SEGCAL_NS;
using test::DenseProblem;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

// Both ways are QR in double on a problem whose scaled condition is about 1e5: what
// differs is 1e-11 or so. A forgotten or wrongly weighted row shows above this
// limit, even the weakest there is (the prior of 30 m/s on the first velocity).
constexpr double kSame = 1e-6;

using Session = test::SyntheticSession;

/// A segment small enough for a dense QR in moments, and yet with every kind of row.
test::SyntheticOptions small_options(std::uint32_t seed, Distortion model = Distortion::fov, int segments = 1,
                                     double gap = 0) {
  test::SyntheticOptions options;
  options.seed = seed;
  options.model = model;
  options.segments = segments;
  options.keyframes = 8;
  options.landmarks = 24;
  options.gap = gap;
  return options;
}

ThetaPrior<double> prior_of(const Calibration<double>& mean) {
  ThetaPrior<double> prior;
  prior.mean = mean;
  default_prior_sigmas(mean, prior.sigma);
  return prior;
}

/// Theta's columns in units of the prior's sigma, so that entries compare.
Eigen::VectorXd scales(const ThetaPrior<double>& prior) {
  return Eigen::Map<const Eigen::VectorXd>(prior.sigma, prior.mean.columns());
}

/// R_theta and d_theta, scaled, of any triangle [theta | rhs] in memory.
template <class S>
Eigen::MatrixXd scaled_triangle(const PackedTriangle<S>& T, const Eigen::VectorXd& scale) {
  const int n = static_cast<int>(scale.size());
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n + 1, n + 1);
  for (int i = 0; i <= n; ++i) {
    for (int c = i; c <= n; ++c) R(i, c) = double(T(i, c)) * (c < n ? scale(c) : 1);
  }
  return R;
}

Eigen::MatrixXd scaled_rows(Eigen::MatrixXd rows, const Eigen::VectorXd& scale) {
  for (int c = 0; c < scale.size(); ++c) rows.col(c) *= scale(c);
  return rows;
}

/// The same quadratic function of theta? Compares the Gram matrices of [theta | rhs].
void check_same_information(const Id& id, const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const int n = static_cast<int>(a.cols()) - 1;
  const Eigen::MatrixXd A = a.transpose() * a, B = b.transpose() * b;
  test::check_near(id, "R'R", 0, (A - B).topLeftCorner(n, n).norm() / B.topLeftCorner(n, n).norm(), kSame);
  test::check_near(id, "R'd", 0, (A - B).col(n).head(n).norm() / B.col(n).head(n).norm(), kSame);
  test::check_near(id, "cost at zero", B(n, n), A(n, n), kSame * B(n, n));
}

/// What is left of the cost at the best theta.
double rho2(const Eigen::MatrixXd& rows) {
  const int n = static_cast<int>(rows.cols()) - 1;
  const Eigen::VectorXd x = rows.leftCols(n).householderQr().solve(rows.col(n));
  return (rows.leftCols(n) * x - rows.col(n)).squaredNorm();
}

/// Solution and covariance of theta in units of the prior's sigma, the prior (identity there, at its mean) included.
struct Estimate {
  Eigen::VectorXd step, sigma;
  Eigen::MatrixXd covariance;
};

Estimate estimate(const Eigen::MatrixXd& rows) {
  const int n = static_cast<int>(rows.cols()) - 1;
  const Eigen::MatrixXd H = rows.leftCols(n).transpose() * rows.leftCols(n) + Eigen::MatrixXd::Identity(n, n);
  Estimate e;
  e.covariance = H.inverse();
  e.step = e.covariance * (rows.leftCols(n).transpose() * rows.col(n));
  e.sigma = e.covariance.diagonal().cwiseSqrt();
  return e;
}

template <class S>
SegmentEliminator<S>* eliminator() {
  static SegmentEliminator<S> instance;
  return &instance;
}

DenseProblem dense_single(const Session& session, double damping) {
  DenseProblem dense({session.segments[0].get()}, session.nominal, session.model, damping);
  dense.hold_gauge(0);
  dense.add_bias_prior(0);
  return dense;
}

/// One segment alone: information, and then the steps of states and landmarks for theta's best step.
void check_single(const Id& id, const Session& session, double damping) {
  const ThetaPrior<double> prior = prior_of(session.nominal);
  const Eigen::VectorXd scale = scales(prior);
  SegmentEliminator<double>* e = eliminator<double>();
  e->eliminate(*session.segments[0], GuestLink<double>(), session.nominal, session.model, damping);
  SegmentInformation<double> information;
  e->extract(&information);
  DenseProblem dense = dense_single(session, damping);
  const Eigen::MatrixXd expected = scaled_rows(dense.reduced(), scale),
                        actual = scaled_triangle(information.triangle(), scale);
  check_same_information(id, actual, expected);
  test::check_near(id, "rho^2", rho2(expected), information.rho2(), kSame * rho2(expected));
  const Estimate a = estimate(actual), b = estimate(expected);
  test::check_near(id, "marginal covariance", 0, (a.covariance - b.covariance).norm() / b.covariance.norm(), kSame);
  test::check_near(id, "theta", 0, (a.step - b.step).norm() / b.step.norm(), kSame);
}

void check_back_substitution(const Id& id, const Session& session, double damping) {
  SegmentEliminator<double>* e = eliminator<double>();
  auto moved = std::make_unique<Segment<double>>(*session.segments[0]);
  e->eliminate(*moved, GuestLink<double>(), session.nominal, session.model, damping);
  DenseProblem dense = dense_single(session, damping);
  dense.add_theta_prior(prior_of(session.nominal));
  const Eigen::VectorXd expected = dense.solution();
  std::vector<double> step(e->theta_column() + session.nominal.columns());
  for (int c = 0; c < session.nominal.columns(); ++c) step[e->theta_column() + c] = expected(dense.theta_column() + c);
  e->back_substitute(*moved, GuestLink<double>(), session.nominal, session.model, damping, step.data(),
                     e->theta_column());
  const int states = kStateColumns * moved->n_keyframes;
  const Eigen::VectorXd actual = Eigen::Map<Eigen::VectorXd>(step.data(), states);
  test::check_near(id, "states", 0, (actual - expected.head(states)).norm() / expected.head(states).norm(), kSame);
  e->move(moved.get(), session.nominal, session.model, damping, step.data());
  for (int j = 0; j < moved->n_landmarks; ++j) {
    Landmark<double> l = session.segments[0]->states.landmark[j];
    add_step(&l, expected.data() + dense.landmark_column(0, j));
    test::check_near(id.add("landmark", j), "direction", 0, (l.m - moved->states.landmark[j].m).norm(), kSame);
    test::check_near(id.add("landmark", j), "rho", l.rho, moved->states.landmark[j].rho,
                     kSame * (1 + std::fabs(l.rho)));
  }
}

void test_single_segment() {
  const struct {
    const char* name;
    Distortion model;
  } models[] = {{"fov", Distortion::fov}, {"radtan", Distortion::radtan}, {"equidistant", Distortion::equidistant}};
  for (const auto& m : models) {
    for (double damping : {0.0, 0.7}) {
      const Session session(small_options(41, m.model));
      const Id id = Id().add("model", m.name).add("damping", damping);
      check_single(id, session, damping);
      check_back_substitution(id.add("step", "back"), session, damping);
    }
  }
}

/// Tracks that drift, and some points far off: whitened together, in both ways.
void test_drifting_tracks() {
  for (double damping : {0.0, 0.7}) {
    test::SyntheticOptions options = small_options(50);
    options.track_walk = 0.9;
    Session session(options);
    for (int o = 0; o < session.segments[0]->n_observations; o += 7) session.segments[0]->observation[o].u += 4;
    const Id id = Id().add("tracks", "drift").add("damping", damping);
    check_single(id, session, damping);
    check_back_substitution(id.add("step", "back"), session, damping);
  }
}

/// The dense problem of a session whose segments hang together as the calibrator says.
DenseProblem dense_chain(const Session& session, Calibrator<double>* calibrator, double damping) {
  std::vector<const Segment<double>*> segments;
  for (const auto& s : session.segments) segments.push_back(s.get());
  DenseProblem dense(segments, session.nominal, session.model, damping);
  for (int s = 0; s < static_cast<int>(segments.size()); ++s) {
    const Join join = calibrator->link(s).join;
    if (join != Join::imu) dense.hold_gauge(s);
    if (join == Join::none) dense.add_bias_prior(s);
    if (join != Join::none) dense.join(s, join, calibrator->link(s).gap_s);
  }
  dense.add_theta_prior(prior_of(session.nominal));
  return dense;
}

Calibrator<double>* begin_calibrator(Session* session) {
  static Calibrator<double> calibrator;
  static ThetaPrior<double> prior;
  prior = prior_of(session->nominal);
  Segment<double>* pointers[kMaxSegments];
  for (std::size_t s = 0; s < session->segments.size(); ++s) pointers[s] = session->segments[s].get();
  calibrator.begin(pointers, static_cast<int>(session->segments.size()), prior, session->nominal, session->model);
  return &calibrator;
}

void check_chain(const Id& id, Session* session, double damping) {
  Calibrator<double>* calibrator = begin_calibrator(session);
  calibrator->linearise(eliminator<double>(), damping);
  const Eigen::VectorXd scale = scales(prior_of(session->nominal));
  const DenseProblem dense = dense_chain(*session, calibrator, damping);
  check_same_information(id, scaled_triangle(calibrator->theta_triangle(), scale), scaled_rows(dense.reduced(), scale));
}

/// One undamped iteration moves theta and every segment's states as the dense joint solution does.
void check_chain_step(const Id& id, Session* session) {
  Calibrator<double>* calibrator = begin_calibrator(session);
  const DenseProblem dense = dense_chain(*session, calibrator, 0);
  const Eigen::VectorXd step = dense.solution();
  Calibration<double> theta = session->nominal;
  add_step(&theta, step.data() + dense.theta_column());
  std::vector<State<double>> expected;
  for (std::size_t s = 0; s < session->segments.size(); ++s) {
    for (int k = 0; k < session->segments[s]->n_keyframes; ++k) {
      expected.push_back(session->segments[s]->states.x[k]);
      expected.back().add(step.data() + dense.state_column(static_cast<int>(s), k));
    }
  }
  CalibratorOptions once;
  once.max_iterations = 1;
  calibrator->run(once, eliminator<double>());
  double offset[kMaxTheta];
  difference(theta, calibrator->theta(), offset);
  for (int i = 0; i < theta.columns(); ++i) {
    test::check_near(id.add("column", i), "theta in sigmas", 0, offset[i] / prior_of(theta).sigma[i], kSame);
  }
  std::size_t n = 0;
  for (const auto& segment : session->segments) {
    for (int k = 0; k < segment->n_keyframes; ++k, ++n) {
      const State<double>&a = segment->states.x[k], &b = expected[n];
      const double error = (a.R_GI - b.R_GI).norm() + (a.p_GI - b.p_GI).norm() + (a.v_GI - b.v_GI).norm() +
                           (a.b_a - b.b_a).norm() + (a.b_g - b.b_g).norm();
      test::check_near(id.add("state", n), "state", 0, error, kSame);
    }
  }
}

void test_segments_joined_by_imu() {
  for (double damping : {0.0, 0.7}) {
    Session session(small_options(42, Distortion::fov, 3));
    TEST_ASSERT_TRUE(begin_calibrator(&session)->link(1).join == Join::imu);
    check_chain(Id().add("join", "imu").add("damping", damping), &session, damping);
  }
  Session session(small_options(42, Distortion::fov, 3));
  check_chain_step(Id().add("join", "imu").add("step", "back"), &session);
}

void test_segments_joined_by_bias_walk() {
  Session session(small_options(43, Distortion::fov, 3, 2.5));
  TEST_ASSERT_TRUE(begin_calibrator(&session)->link(1).join == Join::bias);
  test::check_near(Id().add("join", "bias"), "gap", 2.5, begin_calibrator(&session)->link(1).gap_s, 1e-9);
  check_chain(Id().add("join", "bias"), &session, 0);
  check_chain_step(Id().add("join", "bias").add("step", "back"), &session);
}

void test_mixed_joins() {
  // imu, bias, and a new session with nothing in common.
  Session session(small_options(44, Distortion::fov, 4));
  session.segments[2]->serial = 7;
  session.segments[2]->lead_us = 0;
  session.segments[3]->session = 1;
  const Calibrator<double>* calibrator = begin_calibrator(&session);
  TEST_ASSERT_TRUE(calibrator->link(0).join == Join::none && calibrator->link(1).join == Join::imu);
  TEST_ASSERT_TRUE(calibrator->link(2).join == Join::bias && calibrator->link(3).join == Join::none);
  check_chain(Id().add("join", "mixed"), &session, 0);
  check_chain_step(Id().add("join", "mixed").add("step", "back"), &session);
}

void test_float_agrees_with_double() {
  // Seeds far and near the solution: residuals of some pixels, and of the noise alone.
  for (std::uint32_t seed = 45; seed < 53; ++seed) {
    test::SyntheticOptions options = small_options(seed);
    options.track_walk = seed < 49 ? 0 : 0.9;
    options.start_error = seed % 2;
    options.device = seed % 2;
    const Session session(options);
    const Eigen::VectorXd scale = scales(prior_of(session.nominal));
    auto single = std::make_unique<Segment<float>>();
    auto same = std::make_unique<Segment<double>>();
    test::cast<float>(*session.segments[0], single.get());
    test::cast<double>(*single, same.get());  // double works at the very place that float holds
    SegmentInformation<float> f;
    SegmentInformation<double> d;
    MeasurementModel<float> model;
    model.track_walk = static_cast<float>(session.model.track_walk);
    eliminator<float>()->eliminate(*single, GuestLink<float>(), test::cast<float>(session.nominal), model, 0);
    eliminator<float>()->extract(&f);
    eliminator<double>()->eliminate(*same, GuestLink<double>(), session.nominal, session.model, 0);
    eliminator<double>()->extract(&d);
    const Estimate a = estimate(scaled_triangle(f.triangle(), scale)),
                   b = estimate(scaled_triangle(d.triangle(), scale));
    const Id id = Id().add("check", "float").add("seed", seed);
    TEST_ASSERT_EQUAL_INT(d.dof, f.dof);
    for (int i = 0; i < b.step.size(); ++i) {
      test::check_near(id.add("column", i), "theta in sigmas", 0, (a.step(i) - b.step(i)) / b.sigma(i), 1e-3);
      test::check_near(id.add("column", i), "ratio of sigmas", 1, a.sigma(i) / b.sigma(i), 1e-3);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_single_segment);
  RUN_TEST(test_drifting_tracks);
  RUN_TEST(test_segments_joined_by_imu);
  RUN_TEST(test_segments_joined_by_bias_walk);
  RUN_TEST(test_mixed_joins);
  RUN_TEST(test_float_agrees_with_double);
  return UNITY_END();
}
