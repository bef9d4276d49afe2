// Terms of effects through the elimination: as part of theta and as candidates, segments alone and joined, against a
// dense QR of the full stacked Jacobian; and what candidates must not change.
#include <Eigen/LU>
#include <memory>

#include "../support/cases.h"
#include "../support/dense_problem.h"
#include "../support/synthetic_segments.h"
#include "calibration/calibrator.h"

using namespace SEGCAL_NS;
using test::DenseProblem;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

// Both ways are QR in double on problems whose scaled condition is about 1e5 (as in test_elimination.cpp).
constexpr double kSame = 1e-6;

test::SyntheticOptions small_options(std::uint32_t seed, int segments, double gap = 0) {
  test::SyntheticOptions options;
  options.seed = seed;
  options.segments = segments;
  options.keyframes = 8;
  options.landmarks = 24;
  options.gap = gap;
  return options;
}

/// Some of every kind, camera and IMU in mixed order, with values of a bad device.
void add_estimates(EffectTerms<double>* effects) {
  effects->add(effect_term(4, 1), 4e-4);   // g-sensitivity xy, rad s/m
  effects->add(effect_term(0, 0), 0.004);  // t_d, s
  effects->add(effect_term(9, 0), 0.002);  // lag, s
  effects->add(effect_term(2, 0), 0.004);  // radial
  effects->add(effect_term(10, 4), 0.01);  // axis offset zy, m
  effects->add(effect_term(1, 0), 2e-5);   // line delay, s/row
}

CandidateTerms candidates() {
  CandidateTerms c;
  c.term[c.n++] = effect_term(3, 1);
  c.term[c.n++] = effect_term(6, 2);
  c.term[c.n++] = effect_term(5, 0);
  c.term[c.n++] = {TermKind::image_v, 1, 0, 1};
  c.term[c.n++] = {TermKind::gyro_z, static_cast<std::uint8_t>(Signal::fy), static_cast<std::uint8_t>(Signal::wz), 0};
  c.term[c.n++] = effect_term(10, 0);
  return c;
}

ThetaPrior<double> prior_of(const Calibration<double>& mean) {
  ThetaPrior<double> prior;
  prior.mean = mean;
  default_prior_sigmas(mean, prior.sigma);
  return prior;
}

Eigen::VectorXd scales(const Calibration<double>& theta, const CandidateTerms& c) {
  const ThetaPrior<double> prior = prior_of(theta);
  Eigen::VectorXd out(theta.columns() + c.n);
  for (int i = 0; i < theta.columns(); ++i) out(i) = prior.sigma[i];
  for (int i = 0; i < c.n; ++i) out(theta.columns() + i) = term_prior_sigma(c.term[i]);
  return out;
}

Eigen::MatrixXd scaled(Eigen::MatrixXd rows, const Eigen::VectorXd& scale) {
  for (int c = 0; c < scale.size(); ++c) rows.col(c) *= scale(c);
  return rows;
}

Eigen::MatrixXd matrix(const PackedTriangle<double>& T) {
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(T.columns(), T.columns());
  for (int i = 0; i < T.columns(); ++i) {
    for (int c = i; c < T.columns(); ++c) R(i, c) = T(i, c);
  }
  return R;
}

/// Gram matrices of [theta | candidates | rhs], each column by its own length: a wrong column of a weak term shows.
void check_same(const Id& id, const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::MatrixXd A = a.transpose() * a, B = b.transpose() * b;
  for (int c = 0; c < B.cols(); ++c) {
    for (int r = 0; r <= c; ++r) {
      test::check_near(id.add("row", r).add("column", c), "R'R", 0, (A(r, c) - B(r, c)) / std::sqrt(B(r, r) * B(c, c)),
                       kSame);
    }
  }
}

SegmentEliminator<double>* eliminator() {
  static SegmentEliminator<double> instance;
  return &instance;
}

Eigen::MatrixXd wide_rows(int n) {
  Eigen::MatrixXd rows(n + 1, n + 1);
  for (int i = 0; i <= n; ++i) rows.row(i) = Eigen::Map<const Eigen::RowVectorXd>(eliminator()->wide_row(i), n + 1);
  return rows;
}

void test_terms_against_dense() {
  for (double damping : {0.0, 0.7}) {
    const test::SyntheticSession session(small_options(51, 1));
    Calibration<double> theta = session.nominal;
    add_estimates(&theta.effects);
    const CandidateTerms c = candidates();
    const Segment<double>& segment = *session.segments[0];
    eliminator()->eliminate(segment, GuestLink<double>(), theta, session.model, damping, &c);
    const Eigen::VectorXd scale = scales(theta, c);
    DenseProblem dense({&segment}, theta, session.model, damping, {}, c);
    dense.hold_gauge(0);
    dense.add_bias_prior(0);
    check_same(Id().add("damping", damping), scaled(wide_rows(static_cast<int>(scale.size())), scale),
               scaled(dense.reduced(), scale));
  }
}

/// The segment's own triangle holds theta alone: what candidates stand behind it changes nothing.
void test_candidates_leave_information_alone() {
  const test::SyntheticSession session(small_options(52, 1));
  Calibration<double> theta = session.nominal;
  add_estimates(&theta.effects);
  const CandidateTerms c = candidates();
  SegmentInformation<double> with, without;
  eliminator()->eliminate(*session.segments[0], GuestLink<double>(), theta, session.model, 0);
  eliminator()->extract(&without);
  eliminator()->eliminate(*session.segments[0], GuestLink<double>(), theta, session.model, 0, &c);
  eliminator()->extract(&with);
  TEST_ASSERT_EQUAL_INT(theta.columns(), with.n_theta);
  TEST_ASSERT_EQUAL_INT(without.dof, with.dof);
  const Eigen::VectorXd scale = scales(theta, {});
  check_same(Id().add("check", "candidates"), scaled(matrix(with.triangle()), scale),
             scaled(matrix(without.triangle()), scale));
}

Calibrator<double>* begin(test::SyntheticSession* session, const Calibration<double>& theta) {
  static Calibrator<double> calibrator;
  static ThetaPrior<double> prior;
  prior = prior_of(theta);
  Segment<double>* pointers[kMaxSegments];
  for (std::size_t s = 0; s < session->segments.size(); ++s) pointers[s] = session->segments[s].get();
  calibrator.begin(pointers, static_cast<int>(session->segments.size()), prior, theta, session->model);
  return &calibrator;
}

DenseProblem dense_chain(const std::vector<const Segment<double>*>& segments, const Calibration<double>& theta,
                         const MeasurementModel<double>& model, const CandidateTerms& c) {
  DenseProblem dense(segments, theta, model, 0, {}, c);
  for (int s = 0; s < static_cast<int>(segments.size()); ++s) {
    const SegmentLink<double> link = s > 0 ? link_after(end_of(*segments[s - 1]), *segments[s]) : SegmentLink<double>{};
    if (link.join != Join::imu) dense.hold_gauge(s);
    if (link.join == Join::none) dense.add_bias_prior(s);
    if (link.join != Join::none) dense.join(s, link.join, link.gap_s);
  }
  return dense;
}

/// One iteration moves theta, terms included, as the dense joint solution does.
void test_step_with_terms() {
  for (double gap : {0.0, 2.5}) {
    test::SyntheticSession session(small_options(53, 3, gap));
    Calibration<double> theta = session.nominal;
    add_estimates(&theta.effects);
    DenseProblem dense = dense_chain({session.segments[0].get(), session.segments[1].get(), session.segments[2].get()},
                                     theta, session.model, {});
    Calibrator<double>* calibrator = begin(&session, theta);
    dense.add_theta_prior(prior_of(theta));
    const Eigen::VectorXd step = dense.solution();
    Calibration<double> expected = theta;
    add_step(&expected, step.data() + dense.theta_column());
    CalibratorOptions once;
    once.max_iterations = 1;
    calibrator->run(once, eliminator());
    double offset[kMaxTheta];
    difference(expected, calibrator->theta(), offset);
    for (int i = 0; i < theta.columns(); ++i) {
      test::check_near(Id().add("gap", gap).add("column", i), "theta in sigmas", 0,
                       offset[i] / prior_of(theta).sigma[i], kSame);
    }
  }
}

/// Rows of a part of the segments: as the dense problem of that part, without the prior, and nothing else has changed.
void test_rows_of_some_segments() {
  test::SyntheticSession session(small_options(54, 4));
  Calibration<double> theta = session.nominal;
  add_estimates(&theta.effects);
  const CandidateTerms c = candidates();
  const Eigen::VectorXd scale = scales(theta, c);
  Calibrator<double>* calibrator = begin(&session, theta);
  const struct {
    const char* name;
    bool use[4];
  } sets[] = {{"all", {true, true, true, true}},
              {"neighbours", {false, true, true, false}},
              {"apart", {true, false, false, true}}};
  for (const auto& set : sets) {
    std::vector<const Segment<double>*> used;
    for (int s = 0; s < 4; ++s) {
      if (set.use[s]) used.push_back(session.segments[s].get());
    }
    calibrator->rows_of(set.use, c, eliminator());
    const Eigen::MatrixXd actual = matrix(calibrator->theta_triangle());
    check_same(Id().add("set", set.name), scaled(actual, scale),
               scaled(dense_chain(used, theta, session.model, c).reduced(), scale));
    TEST_ASSERT_EQUAL_INT(4, calibrator->count());
    TEST_ASSERT_TRUE(calibrator->link(2).join == Join::imu);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_terms_against_dense);
  RUN_TEST(test_candidates_leave_information_alone);
  RUN_TEST(test_step_with_terms);
  RUN_TEST(test_rows_of_some_segments);
  return UNITY_END();
}
