// Segments tied by shared landmarks: the calibrator against a dense QR of the full
// Jacobian in which a tie is one landmark, one gauge per partition, degrees of
// freedom, sigmas with and without ties, drift, mistaken tracks, float against double.
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
using test::SyntheticOptions;
using test::SyntheticSession;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

// As in test_elimination: both ways are QR in double, and a row that is forgotten shows above this limit.
constexpr double kSame = 1e-6;

template <class S>
struct Solver {
  Calibrator<S> calibrator;
  SegmentEliminator<S> eliminator;
};

template <class S>
Solver<S>* solver() {
  static Solver<S> instance;
  return &instance;
}

template <class S>
ThetaPrior<S> prior_of(const Calibration<S>& mean) {
  ThetaPrior<S> prior;
  prior.mean = mean;
  default_prior_sigmas(mean, prior.sigma);
  return prior;
}

/// Small enough for a dense QR in moments.
SyntheticOptions small(std::uint32_t seed, int segments, double gap) {
  SyntheticOptions options;
  options.seed = seed;
  options.segments = segments;
  options.keyframes = 8;
  options.landmarks = 14;
  options.shared = 12;
  options.gap = gap;
  return options;
}

Calibrator<double>* begin(SyntheticSession* session) {
  Calibrator<double>* calibrator = &solver<double>()->calibrator;
  static ThetaPrior<double> prior;
  prior = prior_of(session->nominal);
  Segment<double>* pointers[kMaxSegments];
  for (std::size_t s = 0; s < session->segments.size(); ++s) pointers[s] = session->segments[s].get();
  calibrator->begin(pointers, static_cast<int>(session->segments.size()), prior, session->nominal, session->model);
  return calibrator;
}

/// The same problem, dense: joins as the calibrator says, each
/// tie one landmark, the gauge of each partition's first segment.
DenseProblem dense_problem(const SyntheticSession& session, Calibrator<double>* calibrator, double damping) {
  std::vector<const Segment<double>*> segments;
  for (const auto& s : session.segments) segments.push_back(s.get());
  const Ties<double>& ties = calibrator->grouping().ties();
  std::vector<test::SameLandmark> same;
  for (int t = 0; t < ties.count(); ++t) {
    const int first = ties.first_segment(t);
    for (int s = first + 1; s < static_cast<int>(segments.size()); ++s) {
      if (ties.landmark(t, s) >= 0) same.push_back({s, ties.landmark(t, s), first, ties.landmark(t, first)});
    }
  }
  DenseProblem dense(segments, session.nominal, session.model, damping, same);
  for (int s = 0; s < static_cast<int>(segments.size()); ++s) {
    const Join join = calibrator->link(s).join;
    if (calibrator->grouping().first_of(s) == s) dense.hold_gauge(s);
    if (join == Join::none) dense.add_bias_prior(s);
    if (join != Join::none) dense.join(s, join, calibrator->link(s).gap_s);
  }
  dense.add_theta_prior(prior_of(session.nominal));
  return dense;
}

/// Gram matrix over [theta in prior sigmas | rhs].
Eigen::MatrixXd gram(Eigen::MatrixXd rows, const ThetaPrior<double>& prior) {
  for (int c = 0; c + 1 < rows.cols(); ++c) rows.col(c) *= prior.sigma[c];
  return rows.transpose() * rows;
}

template <class S>
Eigen::MatrixXd matrix(const PackedTriangle<S>& T) {
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(T.columns(), T.columns());
  for (int i = 0; i < T.columns(); ++i) {
    for (int c = i; c < T.columns(); ++c) R(i, c) = double(T(i, c));
  }
  return R;
}

template <class S>
Eigen::VectorXd sigmas(const PackedTriangle<S>& T) {
  const int n = T.columns() - 1;
  return matrix(T).topLeftCorner(n, n).inverse().rowwise().norm();
}

void check_information(const Id& id, SyntheticSession* session, double damping) {
  Calibrator<double>* calibrator = begin(session);
  calibrator->linearise(&solver<double>()->eliminator, damping);
  const ThetaPrior<double> prior = prior_of(session->nominal);
  const Eigen::MatrixXd A = gram(matrix(calibrator->theta_triangle()), prior);
  const Eigen::MatrixXd B = gram(dense_problem(*session, calibrator, damping).reduced(), prior);
  const int n = static_cast<int>(A.cols()) - 1;
  test::check_near(id, "R'R", 0, (A - B).topLeftCorner(n, n).norm() / B.topLeftCorner(n, n).norm(), kSame);
  test::check_near(id, "R'd", 0, (A - B).col(n).head(n).norm() / B.col(n).head(n).norm(), kSame);
  test::check_near(id, "cost at zero", B(n, n), A(n, n), kSame * B(n, n));
  const Eigen::VectorXd a = A.topLeftCorner(n, n).inverse().diagonal(), b = B.topLeftCorner(n, n).inverse().diagonal();
  for (int i = 0; i < n; ++i) test::check_near(id.add("column", i), "sigma", 1, std::sqrt(a(i) / b(i)), kSame);
}

bool is_tied(Calibrator<double>& calibrator, int segment, int j) {
  const Ties<double>& ties = calibrator.grouping().ties();
  for (int t = 0; t < ties.count(); ++t) {
    if (ties.landmark(t, segment) == j) return true;
  }
  return false;
}

/// One undamped iteration moves everything as the dense joint solution does, and all copies of a tie alike.
void check_step(const Id& id, SyntheticSession* session) {
  Calibrator<double>* calibrator = begin(session);
  const DenseProblem dense = dense_problem(*session, calibrator, 0);
  const Eigen::VectorXd step = dense.solution();
  std::vector<Segment<double>> expected;
  for (std::size_t s = 0; s < session->segments.size(); ++s) {
    expected.push_back(*session->segments[s]);
    const int i = static_cast<int>(s);
    for (int k = 0; k < expected[s].n_keyframes; ++k)
      expected[s].states.x[k].add(step.data() + dense.state_column(i, k));
    for (int j = 0; j < expected[s].n_landmarks; ++j)
      add_step(&expected[s].states.landmark[j], step.data() + dense.landmark_column(i, j));
  }
  Calibration<double> theta = session->nominal;
  add_step(&theta, step.data() + dense.theta_column());
  // Then each landmark of a single segment goes to its best place; ties stay where the step took them.
  for (std::size_t s = 0; s < expected.size(); ++s) {
    for (int j = 0; j < expected[s].n_landmarks; ++j) {
      if (is_tied(*calibrator, static_cast<int>(s), j)) continue;
      refine_landmark(expected[s], j, theta, session->model, 2, &expected[s].states.landmark[j]);
    }
  }
  CalibratorOptions once;
  once.max_iterations = 1;
  calibrator->run(once, &solver<double>()->eliminator);
  test::check_true(id, "the step was not taken", calibrator->fit().cost < calibrator->fit().start_cost);
  double offset[kMaxTheta];
  difference(theta, calibrator->theta(), offset);
  for (int i = 0; i < theta.columns(); ++i) {
    test::check_near(id.add("column", i), "theta in sigmas", 0, offset[i] / prior_of(theta).sigma[i], kSame);
  }
  for (std::size_t s = 0; s < expected.size(); ++s) {
    const Segment<double>& actual = *session->segments[s];
    for (int k = 0; k < actual.n_keyframes; ++k) {
      const State<double>&a = actual.states.x[k], &b = expected[s].states.x[k];
      const double error = (a.R_GI - b.R_GI).norm() + (a.p_GI - b.p_GI).norm() + (a.v_GI - b.v_GI).norm() +
                           (a.b_a - b.b_a).norm() + (a.b_g - b.b_g).norm();
      test::check_near(id.add("segment", s).add("keyframe", k), "state", 0, error, kSame);
    }
    for (int j = 0; j < actual.n_landmarks; ++j) {
      const Landmark<double>&a = actual.states.landmark[j], &b = expected[s].states.landmark[j];
      test::check_near(id.add("segment", s).add("landmark", j), "landmark", 0,
                       (a.m - b.m).norm() + std::fabs(a.rho - b.rho), kSame);
    }
  }
}

/// Segments 0 1 | 2 3, the bar a gap, ties between 0 and 3 only: those in between hang on their neighbours by the IMU.
SyntheticSession mixed(std::uint32_t seed) {
  SyntheticSession session(small(seed, 4, 0));
  session.segments[2]->lead_us = 0;
  for (int s : {1, 2}) {
    for (int j = 0; j < session.segments[s]->n_landmarks; ++j) session.segments[s]->track_id[j] += 10000u * (1u + s);
  }
  return session;
}

/// Two maps: 0 1 of one frame, 2 3 of the next; a bias walk between all. `error`: of device and states.
SyntheticSession two_frames(std::uint32_t seed, double error) {
  SyntheticOptions options = small(seed, 4, 1.5);
  options.device = options.start_error = error;
  SyntheticSession session(options);
  session.segments[2]->frame = session.segments[3]->frame = 1;
  return session;
}

void check_against_dense(const Id& id, SyntheticSession (*make)(std::uint32_t), std::uint32_t seed, int partitions,
                         int ties) {
  for (double damping : {0.0, 0.7}) {
    SyntheticSession session = make(seed);
    Calibrator<double>* calibrator = begin(&session);
    TEST_ASSERT_EQUAL_INT(partitions, calibrator->partitions());
    TEST_ASSERT_EQUAL_INT(ties, calibrator->grouping().ties().count());
    check_information(id.add("damping", damping), &session, damping);
  }
  SyntheticSession session = make(seed);
  check_step(id.add("step", "back"), &session);
}

void test_against_dense() {
  for (std::uint32_t seed : {41u, 42u}) {
    const Id id = Id().add("seed", seed);
    check_against_dense(
        id.add("case", "pair"), [](std::uint32_t s) { return SyntheticSession(small(s, 2, 2)); }, seed, 1,
        kTiesPerEdge);
    check_against_dense(
        id.add("case", "star"), [](std::uint32_t s) { return SyntheticSession(small(s, 3, 2)); }, seed, 1,
        kTiesPerEdge);
    check_against_dense(id.add("case", "mixed"), mixed, seed, 1, kTiesPerEdge);
    check_against_dense(
        id.add("case", "frames"), [](std::uint32_t s) { return two_frames(s, 1); }, seed, 2, 2 * kTiesPerEdge);
  }
}

/// A turn about gravity and a shift of all that a segment holds.
void move_segment(const Mat3<double>& turn, const Vec3<double>& shift, Segment<double>* segment) {
  for (int k = 0; k < segment->n_keyframes; ++k) {
    State<double>& x = segment->states.x[k];
    x.R_GI = turn * x.R_GI;
    x.p_GI = turn * x.p_GI + shift;
    x.v_GI = turn * x.v_GI;
  }
  for (int j = 0; j < segment->n_landmarks; ++j) {
    Landmark<double>& l = segment->states.landmark[j];
    l.o = turn * l.o + shift;
    l.m = turn * l.m;
  }
}

void test_one_gauge() {
  SyntheticSession session = two_frames(43, 0);
  Calibrator<double>* calibrator = begin(&session);
  const double cost = calibrator->total_cost();
  const Mat3<double> turn = so3_exp<double>({0, 0, 0.8});
  for (int s : {2, 3}) move_segment(turn, {3, -2, 1}, session.segments[s].get());
  const Id id = Id().add("check", "gauge");
  // What is left is rounding of the sums.
  test::check_near(id.add("moved", "partition"), "cost", cost, calibrator->total_cost(), 1e-9 * cost);
  // One segment with its own landmarks, while the ties stay where the other one sees them: 0.02 rad are ten sigmas of
  // an image point, over some 30 points.
  SyntheticSession apart = two_frames(43, 0);
  calibrator = begin(&apart);
  const SegmentStates<double> was = apart.segments[1]->states;
  move_segment(so3_exp<double>({0, 0, 0.02}), {0.05, 0, 0}, apart.segments[1].get());
  const Ties<double>& ties = calibrator->grouping().ties();
  for (int t = 0; t < ties.count(); ++t) {
    const int j = ties.landmark(t, 1);
    if (j >= 0) apart.segments[1]->states.landmark[j] = was.landmark[j];
  }
  test::check_true(id.add("moved", "segment"), "the cost does not feel the ties",
                   calibrator->total_cost() > cost + 500);
}

/// Degrees of freedom, counted once more: image residuals and links against all that is estimated.
void test_degrees_of_freedom() {
  SyntheticSession session = mixed(44);
  Calibrator<double>* calibrator = begin(&session);
  calibrator->linearise(&solver<double>()->eliminator, 0);
  const DenseProblem dense = dense_problem(session, calibrator, 0);
  int points = 0, landmarks = 0, links = 0;
  for (const auto& s : session.segments) {
    points += s->n_observations;
    landmarks += s->n_landmarks;
    links += s->n_keyframes - 1;
  }
  landmarks -= calibrator->grouping().ties().count();  // each is seen by two segments
  // IMU joins 0-1 and 2-3, six rows of bias walk, one gauge of four; the bias prior holds six.
  const double residuals = 2 * points + 15 * (links + 2) + 6, unknowns = dense.columns() - 4 - 6;
  TEST_ASSERT_EQUAL_INT(dense.columns(), 15 * 4 * 8 + 3 * landmarks + session.nominal.columns());
  // The prior on inverse depths fixes a part of each: between nothing and all of them.
  test::check_between(Id().add("check", "dof"), "degrees of freedom", residuals - unknowns, calibrator->fit().dof,
                      residuals - unknowns + landmarks);
  test::check_near(Id().add("check", "points"), "image points", points, calibrator->fit().image_points, 0);
  // Without the ties: nine unknowns more for each of them but three, and the second gauge.
  const double tied = calibrator->fit().dof;
  session.segments[2]->frame = session.segments[3]->frame = 1;
  const int ties = calibrator->grouping().ties().count();
  calibrator = begin(&session);
  calibrator->linearise(&solver<double>()->eliminator, 0);
  // Their distances are known to a tenth: the prior's share in each is below (1/3 / (10 rho))^2, hence below 0.05.
  test::check_near(Id().add("check", "dof_untied"), "difference", 3 * ties - 4, tied - calibrator->fit().dof,
                   0.05 * ties);
}

struct Outcome {
  CalibrationFit<double> fit;
  int partitions;
  Eigen::VectorXd sigma, normalised;  ///< error against the truth in sigmas
  Calibration<double> theta;
};

template <class S>
Outcome calibrate(const SyntheticSession& session, bool tied = true, double outliers = 0) {
  Calibrator<S>* calibrator = &solver<S>()->calibrator;
  test::Copies<S> copies(session.segments);
  for (int i = 0; !tied && i < copies.count(); ++i) copies.pointer[i]->frame = static_cast<std::uint32_t>(i + 1);
  const Calibration<S> nominal = test::cast<S>(session.nominal);
  const ThetaPrior<S> prior = prior_of(nominal);
  calibrator->begin(copies.pointer, copies.count(), prior, nominal, MeasurementModel<S>());
  calibrator->run(CalibratorOptions(), &solver<S>()->eliminator);
  if (outliers > 0) {
    calibrator->reject_outliers(S(outliers));
    calibrator->run(CalibratorOptions(), &solver<S>()->eliminator);
  }
  const CalibrationFit<S>& f = calibrator->fit();
  Outcome out;
  out.fit = {f.converged,    f.iterations,   f.image_points, double(f.start_cost),
             double(f.cost), double(f.chi2), double(f.dof)};
  out.partitions = calibrator->partitions();
  out.theta = test::cast<double>(calibrator->theta());
  out.sigma = sigmas(calibrator->theta_triangle());
  out.normalised.resize(out.sigma.size());
  difference(session.truth, out.theta, out.normalised.data());
  out.normalised = out.normalised.cwiseQuotient(out.sigma);
  return out;
}

SyntheticOptions device(std::uint32_t seed) {
  SyntheticOptions options;
  options.seed = seed;
  options.segments = 3;
  options.keyframes = 14;
  options.landmarks = 40;
  options.shared = 16;
  options.gap = 3;
  return options;
}

void check_outcome(const Id& id, const Outcome& out) {
  test::check_true(id, "did not converge", out.fit.converged);
  const double spread = 5 * std::sqrt(2 / out.fit.dof);  // chi2 of d degrees of freedom has sigma sqrt(2 d)
  test::check_between(id, "chi2/dof", 1 - spread, out.fit.chi2 / out.fit.dof, 1 + spread);
  for (int i = 0; i < out.normalised.size(); ++i)
    test::check_near(id.add("column", i), "error in sigmas", 0, out.normalised(i), 5);
}

void test_ties_add_information() {
  for (std::uint32_t seed = 71; seed < 75; ++seed) {
    const SyntheticSession session(device(seed));
    const Outcome tied = calibrate<float>(session), apart = calibrate<float>(session, false);
    const Id id = Id().add("check", "gain").add("seed", seed);
    check_outcome(id.add("which", "tied"), tied);
    check_outcome(id.add("which", "apart"), apart);
    TEST_ASSERT_EQUAL_INT(1, tied.partitions);
    TEST_ASSERT_EQUAL_INT(3, apart.partitions);
    for (int i = 0; i < tied.sigma.size(); ++i) {
      // Sigmas are taken at slightly different minima: one per cent.
      test::check_between(id.add("column", i), "tied over apart", 0, tied.sigma(i) / apart.sigma(i), 1.01);
    }
    test::check_between(id, "best gain", 0, tied.sigma.cwiseQuotient(apart.sigma).minCoeff(), 0.99);
  }
}

void test_drift_of_the_frame() {
  // Segments are off by 1 degree and 6 cm against each other, one sigma: an odometry's drift over the gap.
  for (std::uint32_t seed = 81; seed < 84; ++seed) {
    SyntheticOptions options = device(seed);
    options.drift = 0.02;
    const Outcome out = calibrate<float>(SyntheticSession(options));
    const Id id = Id().add("check", "drift").add("seed", seed);
    check_outcome(id, out);
    TEST_ASSERT_EQUAL_INT(1, out.partitions);
  }
}

void test_mistaken_tracks() {
  // In the middle segment two pairs of the shared tracks are exchanged. Four of sixteen tell a lie: their points go,
  // the rest of the ties or others stay.
  for (std::uint32_t seed = 85; seed < 88; ++seed) {
    SyntheticSession session(device(seed));
    for (std::uint32_t& id : session.segments[1]->track_id) id = id < 4 ? id ^ 1u : id;
    const Outcome out = calibrate<float>(session, true, 5);
    const Id id = Id().add("check", "mistaken").add("seed", seed);
    test::check_true(id, "did not converge", out.fit.converged);
    for (int i = 0; i < out.normalised.size(); ++i)
      test::check_near(id.add("column", i), "error in sigmas", 0, out.normalised(i), 5);
  }
}

void test_ties_without_points_give_way_to_a_gauge() {
  // After the ties were chosen, all image points of the shared tracks in segment 1 go astray by 20 to 60 px.
  SyntheticSession session(device(95));
  Calibrator<double>* calibrator = begin(&session);
  TEST_ASSERT_EQUAL_INT(1, calibrator->partitions());
  test::Random random(96);
  Segment<double>& spoilt = *session.segments[1];
  int astray = 0, left_out = 0;
  for (int o = 0; o < spoilt.n_observations; ++o) {
    Observation& z = spoilt.observation[o];
    if (spoilt.track_id[z.landmark] >= 16) continue;
    z.u += static_cast<float>((random.index(2) ? 1 : -1) * random.uniform(20, 60));
    z.v += static_cast<float>((random.index(2) ? 1 : -1) * random.uniform(20, 60));
    ++astray;
  }
  calibrator->run(CalibratorOptions(), &solver<double>()->eliminator);
  calibrator->reject_outliers(5);
  calibrator->run(CalibratorOptions(), &solver<double>()->eliminator);
  for (int o = 0; o < spoilt.n_observations; ++o) left_out += spoilt.observation[o].rejected;
  const Id id = Id().add("check", "lost");
  test::check_between(id, "points left out of those astray", 0.8, double(left_out) / astray, 1.2);
  test::check_true(id, "did not converge", calibrator->fit().converged);
  TEST_ASSERT_EQUAL_INT(2, calibrator->partitions());
  test::check_true(id, "the lone segment holds its gauge",
                   calibrator->grouping().first_of(1) == 1 && calibrator->grouping().first_of(2) == 0);
}

void test_float_equals_double() {
  for (std::uint32_t seed : {91u, 92u}) {
    const SyntheticSession session(device(seed));
    const Outcome f = calibrate<float>(session), d = calibrate<double>(session);
    const Id id = Id().add("check", "float").add("seed", seed);
    for (int i = 0; i < d.sigma.size(); ++i) {
      // Both stop within 0.03 sigma of the minimum.
      test::check_near(id.add("column", i), "difference in sigmas", 0, f.normalised(i) - d.normalised(i),
                       0.05 + 0.01 * std::fabs(d.normalised(i)));
      test::check_near(id.add("column", i), "ratio of sigmas", 1, f.sigma(i) / d.sigma(i), 0.01);
    }
    test::check_near(id, "chi2", d.fit.chi2, f.fit.chi2, 0.01 * d.fit.chi2);
    test::check_near(id, "dof", d.fit.dof, f.fit.dof, 0.01);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_against_dense);
  RUN_TEST(test_one_gauge);
  RUN_TEST(test_degrees_of_freedom);
  RUN_TEST(test_ties_add_information);
  RUN_TEST(test_drift_of_the_frame);
  RUN_TEST(test_mistaken_tracks);
  RUN_TEST(test_ties_without_points_give_way_to_a_gauge);
  RUN_TEST(test_float_equals_double);
  return UNITY_END();
}
