// A segment's rows, sensor by sensor, against dense QRs of the
// full stacked Jacobian: squares, and what noise adds to them.
#include <Eigen/QR>

#include "../support/cases.h"
#include "../support/dense_problem.h"
#include "../support/synthetic_segments.h"
#include "calibration/prior.h"
#include "replay/profile/segment_rows.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace SEGCAL_NS;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using host::CoreSensorRows;
using test::DenseProblem;
using test::Id;

// The rows under test are squared, and held by 1e5 beside weights of 1e-3: of double's sixteen digits eight are left,
// at a scaled condition of some 100.
constexpr double kSame = 1e-6;

/// Terms of the image and of the IMU, some with columns of theta.
struct Case {
  test::SyntheticSession session;
  Calibration<double> theta;
  CandidateTerms candidates;
};

Case case_of(std::uint32_t seed, double track_walk) {
  test::SyntheticOptions options;
  options.seed = seed;
  options.segments = 1;
  options.keyframes = 8;
  options.landmarks = 24;
  options.track_walk = track_walk;
  Case out{test::SyntheticSession(options), {}, {}};
  out.theta = out.session.nominal;
  out.theta.effects.add(effect_term(4, 1), 4e-4);  // g-sensitivity xy, rad s/m
  out.theta.effects.add(effect_term(1, 0), 2e-5);  // line delay, s/row
  out.candidates.term[out.candidates.n++] = effect_term(3, 1);
  out.candidates.term[out.candidates.n++] = effect_term(9, 0);
  out.candidates.term[out.candidates.n++] = effect_term(10, 4);
  return out;
}

/// The same three answers from the stacked rows: the projection
/// along the unknowns of priors and the first k + 1 sensors.
class Dense {
 public:
  Dense(const Case& c, const Segment<double>& segment)
      : problem_({&segment}, c.theta, c.session.model, 0, {}, c.candidates) {
    problem_.hold_gauge(0);
    problem_.add_bias_prior(0);
    rows_ = problem_.rows();
    sensor_ = problem_.sensors();
    const double open[5] = {10, 100, 1e3, 1e3, 100};  // of the states, as the rows under test have them
    const Eigen::Index first = rows_.rows(), states = kStateColumns * segment.n_keyframes;
    rows_.conservativeResize(first + states, Eigen::NoChange);
    rows_.bottomRows(states).setZero();
    for (Eigen::Index i = 0; i < states; ++i) rows_(first + i, i) = 1 / open[i % kStateColumns / 3];
    sensor_.resize(rows_.rows(), DenseProblem::kPrior);
  }

  /// Squares over [theta | candidates | rhs] of the first k + 1 sensors, and the share of each row that is left.
  MatrixXd squares(int k, VectorXd* left) const {
    std::vector<Eigen::Index> of;
    for (Eigen::Index i = 0; i < rows_.rows(); ++i) {
      if (static_cast<int>(sensor_[i]) <= DenseProblem::kCamera + k) of.push_back(i);
    }
    const Eigen::Index n = problem_.theta_column(), m = static_cast<Eigen::Index>(of.size());
    const Eigen::HouseholderQR<MatrixXd> qr(rows_(of, Eigen::seqN(0, n)));
    const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(m, n);
    const MatrixXd w = rows_(of, Eigen::lastN(rows_.cols() - n)), rest = w - Q * (Q.transpose() * w);
    *left = VectorXd::Zero(rows_.rows());
    for (Eigen::Index i = 0; i < m; ++i) (*left)(of[i]) = 1 - Q.row(i).squaredNorm();
    return rest.transpose() * rest;
  }
  double of_sensor(const VectorXd& left, int t) const {
    double out = 0;
    for (Eigen::Index i = 0; i < left.size(); ++i)
      out += static_cast<int>(sensor_[i]) == DenseProblem::kCamera + t ? left(i) : 0;
    return out;
  }

 private:
  DenseProblem problem_;
  MatrixXd rows_;
  std::vector<DenseProblem::Sensor> sensor_;
};

/// Columns by their lengths in the sum of all sensors: what a sensor does not know is next to nothing beside it.
void check_squares(const Id& id, const MatrixXd& got, const MatrixXd& expected, const VectorXd& length) {
  for (Eigen::Index c = 0; c < expected.cols(); ++c) {
    for (Eigen::Index r = 0; r <= c; ++r) {
      const double apart = (got(r, c) - expected(r, c)) / (length(r) * length(c));
      test::check_near(id.add("row", static_cast<int>(r)).add("column", static_cast<int>(c)), "square", 0, apart,
                       kSame);
    }
  }
}

void test_against_dense() {
  for (double track_walk : {0.0, 0.9}) {
    for (std::uint32_t seed : {51u, 52u, 53u, 54u, 55u, 56u, 57u, 58u, 59u, 60u}) {
      const Case c = case_of(seed, track_walk);
      const Segment<double>& segment = *c.session.segments[0];
      const CoreSensorRows rows =
          host::SEGCAL_NS::SegmentRows(segment, c.theta, c.session.model, c.candidates).eliminated();
      const Dense dense(c, segment);
      VectorXd left, left_before = VectorXd::Zero(0);
      MatrixXd before = MatrixXd::Zero(rows.root[0].cols(), rows.root[0].cols());
      const VectorXd length = dense.squares(2, &left).diagonal().cwiseSqrt();
      for (int s = 0; s < 3; ++s) {
        const Id id = Id().add("walk", track_walk).add("seed", seed).add("sensor", s);
        const MatrixXd sum = dense.squares(s, &left);
        check_squares(id, rows.root[s].transpose() * rows.root[s], sum - before, length);
        for (int t = 0; t < 3; ++t) {
          const double of_before = s > t ? dense.of_sensor(left_before, t) : 0,
                       expected = t > s ? 0 : dense.of_sensor(left, t) - of_before;
          // A landmark's prior counts as a measurement for the part that it has of the landmark with states known. With
          // states unknown it has more where parallax is little: 0.09 of 134 at most in these four.
          test::check_near(id.add("noise", t), "degrees of freedom", expected, rows.shared(s, t),
                           s == t && t > 0 ? 1e-4 : 0.15);
        }
        before = sum;
        left_before = left;
      }
    }
  }
}

/// What a camera has left of a column that it does not know is rounding: a diagonal just below zero, beside entries
/// that are no smaller. The column is zero, and the others are what they are without it.
void test_rounding_is_no_direction() {
  MatrixXd square(3, 3), known(2, 2);
  square << 4, 1e-12, 1,  //
      1e-12, -1e-17, -3e-12, 1, -3e-12, 9;
  known << 4, 1, 1, 9;
  for (double diagonal : {-1e-17, 0.0, 1e-17}) {
    square(1, 1) = diagonal;
    const MatrixXd R = host::SEGCAL_NS::root_of_squares(square, square, Eigen::Vector3d(10, 10, 10));
    const MatrixXd again = R.transpose() * R;
    const Id id = Id().add("diagonal", diagonal);
    test::check_near(id, "the column's length", 0, R.col(1).norm(), 0);
    for (int r : {0, 2}) {
      for (int c : {0, 2}) {
        test::check_near(id.add("row", r).add("column", c), "square", known(r / 2, c / 2), again(r, c), 1e-12);
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_against_dense);
  RUN_TEST(test_rounding_is_no_direction);
  return UNITY_END();
}
