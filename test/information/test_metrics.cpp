// Metrics of a segment's information against closed forms in double
// (Eigen): A, D, E, gain, rank, and the directions that were not excited.
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

#include "../support/cases.h"
#include "../support/random.h"
#include "information/metrics.h"

using namespace SEGCAL_NS;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr int kColumns = 26;

/// Prior and reference sigmas of very different sizes, as theta's are (pixels beside metres).
struct Sigmas {
  VectorXd prior, reference;
  explicit Sigmas(test::Random* random) : prior(kColumns), reference(kColumns) {
    for (int i = 0; i < kColumns; ++i) {
      prior(i) = std::pow(10, random->uniform(-2, 1));
      reference(i) = prior(i) * random->uniform(0.3, 2);
    }
  }
};

MatrixXd upper_triangle(const MatrixXd& A) {
  return A.householderQr().matrixQR().topRows(kColumns).triangularView<Eigen::Upper>();
}

/// A triangle with the given singular values in prior units.
MatrixXd triangle_with(const VectorXd& s, const VectorXd& prior, test::Random* random, MatrixXd* directions) {
  const MatrixXd U = random->matrix(kColumns, kColumns).householderQr().householderQ();
  const MatrixXd V = random->matrix(kColumns, kColumns).householderQr().householderQ();
  if (directions) *directions = V;
  const MatrixXd W = U * s.asDiagonal() * V.transpose();
  return upper_triangle(W * prior.cwiseInverse().asDiagonal());
}

template <class S>
SegmentInformation<S> information_of(const MatrixXd& R) {
  SegmentInformation<S> information;
  information.n_theta = kColumns;
  PackedTriangle<S> T = information.triangle();
  T.clear();
  for (int i = 0; i < kColumns; ++i) {
    for (int c = i; c < kColumns; ++c) T.row(i)[c] = static_cast<S>(R(i, c));
  }
  return information;
}

template <class S>
struct InScalar {
  S prior[kMaxTheta], reference[kMaxTheta];
  explicit InScalar(const Sigmas& sigmas) {
    for (int i = 0; i < kColumns; ++i) {
      prior[i] = static_cast<S>(sigmas.prior(i));
      reference[i] = static_cast<S>(sigmas.reference(i));
    }
  }
};

/// The closed form: covariance (R'R + P^-1)^-1, normalised by the reference sigmas.
/// Inverted in prior units, where the condition is that of the information alone;
/// determinants are taken before the inversion, which blurs small variances.
Metrics<double> closed_form(const MatrixXd& R, const Sigmas& sigmas) {
  const MatrixXd W = R * sigmas.prior.asDiagonal();
  const MatrixXd information = W.transpose() * W + MatrixXd::Identity(kColumns, kColumns),
                 in_prior = information.inverse();
  const VectorXd ratio = sigmas.prior.cwiseQuotient(sigmas.reference);
  const MatrixXd scaled = ratio.asDiagonal() * in_prior * ratio.asDiagonal();
  Metrics<double> m;
  m.A = scaled.trace();
  m.gain = MatrixXd(information.llt().matrixL()).diagonal().array().log().sum();
  m.D = 2 * ratio.array().log().sum() - 2 * m.gain;
  m.E = Eigen::SelfAdjointEigenSolver<MatrixXd>(scaled).eigenvalues().maxCoeff();
  const VectorXd variances = Eigen::SelfAdjointEigenSolver<MatrixXd>(in_prior).eigenvalues();
  m.rank = static_cast<int>((variances.array() < 0.25).count());
  return m;
}

template <class S>
void check_metrics(const Id& id, const Metrics<double>& expected, const Metrics<S>& actual) {
  const bool single = std::is_same<S, float>::value;
  // Float: singular values of up to 1e3 are good to 1e-4 each, sums of 26 terms. E comes from a power iteration that
  // stops when a step changes it by 1e-6; with close eigenvalues that is still 1e-3 away.
  test::check_near(id, "A", expected.A, actual.A, (single ? 1e-4 : 1e-9) * expected.A);
  test::check_near(id, "D", expected.D, actual.D, (single ? 1e-3 : 1e-8));
  test::check_near(id, "gain", expected.gain, actual.gain, (single ? 1e-3 : 1e-8));
  test::check_near(id, "E", expected.E, actual.E, 2e-3 * expected.E);
  test::check_near(id, "rank", expected.rank, actual.rank, 0);
}

template <class S>
InformationAnalysis<S>* analysis() {
  static InformationAnalysis<S> instance;
  static S work[kMaxTheta * kMaxTheta];
  instance.W = work;
  return &instance;
}

/// Singular values from nothing to `largest`, evenly in their logarithm.
VectorXd graded(double smallest, double largest) {
  VectorXd s(kColumns);
  for (int i = 0; i < kColumns; ++i) s(i) = smallest * std::pow(largest / smallest, i / (kColumns - 1.0));
  return s;
}

template <class S>
void check_closed_form() {
  const double ranges[][2] = {{0.1, 10}, {1e-3, 1e3}, {30, 300}, {1e-6, 1e-2}};
  for (int seed = 0; seed < 5; ++seed) {
    for (const auto& range : ranges) {
      test::Random random(101 + seed);
      const Sigmas sigmas(&random);
      const MatrixXd R = triangle_with(graded(range[0], range[1]), sigmas.prior, &random, nullptr);
      const InScalar<S> in(sigmas);
      analyse(information_of<S>(R), in.prior, analysis<S>());
      const Metrics<S> m = metrics_of(analysis<S>(), in.prior, in.reference);
      check_metrics(Id().add("check", "closed_form").type<S>().add("seed", seed).add("largest", range[1]),
                    closed_form(R, sigmas), m);
    }
  }
}

template <class S>
void check_nothing_known() {
  // No information at all: the covariance is the prior's, A counts parameters, gain and rank are zero.
  test::Random random(111);
  const Sigmas sigmas(&random);
  const InScalar<S> in(sigmas);
  analyse(information_of<S>(MatrixXd::Zero(kColumns, kColumns)), in.prior, analysis<S>());
  const Metrics<S> m = metrics_of(analysis<S>(), in.prior, in.prior);
  const Id id = Id().add("check", "nothing").type<S>();
  test::check_near(id, "A", kColumns, m.A, 1e-4);
  test::check_near(id, "D", 0, m.D, 1e-6);
  test::check_near(id, "E", 1, m.E, 1e-5);
  test::check_near(id, "gain", 0, m.gain, 1e-6);
  test::check_near(id, "rank", 0, m.rank, 0);
}

/// Directions in the null space of R must be found again, as a space: single vectors in it are arbitrary.
template <class S>
void check_blind_directions() {
  for (int blind : {1, 2, 7}) {
    test::Random random(121 + blind);
    const Sigmas sigmas(&random);
    VectorXd s = graded(5, 500);
    s.tail(blind).setZero();
    MatrixXd V;
    const MatrixXd R = triangle_with(s, sigmas.prior, &random, &V);
    const InScalar<S> in(sigmas);
    InformationAnalysis<S>* a = analysis<S>();
    analyse(information_of<S>(R), in.prior, a);
    const Id id = Id().add("check", "blind").type<S>().add("blind", blind);
    const MatrixXd null_space = V.rightCols(blind);
    for (int i = kColumns - blind; i < kColumns; ++i) {
      VectorXd direction(kColumns);
      for (int j = 0; j < kColumns; ++j) direction(j) = a->V[j * kColumns + i];
      // Float: rounding of R's entries is 6e-8 of 500 beside a gap of 5.
      test::check_near(id.add("column", i), "relative sigma", 1, a->relative_sigma(i), 1e-4);
      test::check_near(id.add("column", i), "length", 1, direction.norm(), 1e-4);
      test::check_near(id.add("column", i), "outside the null space", 0,
                       (direction - null_space * (null_space.transpose() * direction)).norm(), 1e-3);
    }
    test::check_true(id, "an excited direction counts as blind", a->relative_sigma(kColumns - blind - 1) < S(0.5));
  }
}

/// A single parameter that nothing depends on, which is how it looks in practice: its column is zero.
template <class S>
void check_blind_parameter() {
  test::Random random(131);
  const Sigmas sigmas(&random);
  const int blind = 9;
  MatrixXd A = random.matrix(60, kColumns) * (10 * sigmas.prior.cwiseInverse()).asDiagonal();
  A.col(blind).setZero();
  const InScalar<S> in(sigmas);
  InformationAnalysis<S>* a = analysis<S>();
  analyse(information_of<S>(upper_triangle(A)), in.prior, a);
  const Id id = Id().add("check", "parameter").type<S>();
  test::check_near(id, "weight", 1, std::fabs(double(a->V[blind * kColumns + kColumns - 1])), 1e-4);
  test::check_near(id, "rank", kColumns - 1, metrics_of(a, in.prior, in.reference).rank, 0);
}

template <class S>
void check_analysis_with_prior() {
  // The triangle that calibration ends with holds the prior's
  // rows already: the same directions and sigmas must come out.
  test::Random random(141);
  const Sigmas sigmas(&random);
  const MatrixXd R = triangle_with(graded(0.5, 50), sigmas.prior, &random, nullptr);
  MatrixXd stacked(2 * kColumns, kColumns);
  stacked << R, MatrixXd(sigmas.prior.cwiseInverse().asDiagonal());
  const MatrixXd both = upper_triangle(stacked);
  S data[packed_size(kColumns + 1)];
  PackedTriangle<S> T(data, kColumns + 1);
  T.clear();
  for (int i = 0; i < kColumns; ++i) {
    for (int c = i; c < kColumns; ++c) T.row(i)[c] = static_cast<S>(both(i, c));
  }
  const InScalar<S> in(sigmas);
  analyse_with_prior(T, in.prior, analysis<S>());
  const VectorXd expected = graded(0.5, 50).reverse();
  for (int i = 0; i < kColumns; ++i) {
    // s comes from sqrt((1 + s^2) - 1): absolute error of some 1e-5 in float.
    test::check_near(Id().add("check", "with_prior").type<S>().add("column", i), "singular value", expected(i),
                     analysis<S>()->s[i], (std::is_same<S, float>::value ? 1e-4 : 1e-10) * (1 + expected(i)));
  }
}

template <class S>
void check_all() {
  check_closed_form<S>();
  check_nothing_known<S>();
  check_blind_directions<S>();
  check_blind_parameter<S>();
  check_analysis_with_prior<S>();
}

void test_metrics_in_float() { check_all<float>(); }
void test_metrics_in_double() { check_all<double>(); }

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_metrics_in_float);
  RUN_TEST(test_metrics_in_double);
  return UNITY_END();
}
