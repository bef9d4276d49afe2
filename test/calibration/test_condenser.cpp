// Epochs: their algebra, and a chain of segments condensed one by one against the same segments in one fit.
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

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// A fit of a whole session, which stands at its optimum.
struct Fit {
  Calibrator<double> calibrator;
  SegmentEliminator<double> eliminator;
  ThetaPrior<double> prior;
  Segment<double>* segment[kMaxSegments];
  int n = 0;
};

Matrix square(const PackedTriangle<double>& T, int n) {
  Matrix R = Matrix::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    for (int c = i; c < n; ++c) R(i, c) = T(i, c);
  }
  return R;
}

SyntheticOptions device(std::uint32_t seed) {
  SyntheticOptions options;
  options.seed = seed;
  options.segments = 4;
  options.keyframes = 12;
  options.landmarks = 40;
  return options;
}

std::unique_ptr<Fit> fit(SyntheticSession* session) {
  auto f = std::make_unique<Fit>();
  for (auto& s : session->segments) f->segment[f->n++] = s.get();
  f->prior.mean = session->nominal;
  default_prior_sigmas(f->prior.mean, f->prior.sigma);
  f->calibrator.begin(f->segment, f->n, f->prior, f->prior.mean, MeasurementModel<double>());
  f->calibrator.run(CalibratorOptions(), &f->eliminator);
  return f;
}

/// Condenses the segments at theta, in their order.
Epoch<double> condense(Fit* f, const Calibration<double>& theta, bool linked) {
  Epoch<double> epoch;
  Condenser<double> condenser;
  epoch.begin(theta, 0);
  for (int i = 0; i < f->n; ++i) {
    condenser.restart();
    if (!linked) condenser.break_chain();
    const CondenseMemory<double> memory = f->calibrator.begin_condensing(&f->eliminator);
    while (!condenser.step(f->segment[i], MeasurementModel<double>(), memory, &epoch)) {
    }
    TEST_ASSERT_TRUE(condenser.condensed());
    condenser.take(f->segment[i], memory, {}, &epoch);
  }
  return epoch;
}

/// With the prior, as covariance.
Matrix covariance(const Epoch<double>& epoch, const ThetaPrior<double>& prior) {
  const int n = epoch.columns();
  const Matrix R = square(PackedTriangle<double>(const_cast<double*>(epoch.information.data), n + 1), n);
  const Vector sigma = Eigen::Map<const Vector>(prior.sigma, n);
  const Matrix H = R.transpose() * R + Matrix(sigma.cwiseAbs2().cwiseInverse().asDiagonal());
  return H.inverse();
}

void test_condensed_chain_tells_what_one_fit_tells() {
  for (int seed = 1; seed <= 6; ++seed) {
    const Id id = Id().add("seed", seed);
    SyntheticSession session(device(300 + seed));
    auto f = fit(&session);
    const int n = f->prior.mean.columns();
    const Calibration<double> theta = f->calibrator.theta();
    const Matrix R = square(f->calibrator.theta_triangle(), n);
    const Matrix joint = (R.transpose() * R).inverse();
    const Matrix linked = covariance(condense(f.get(), theta, true), f->prior);
    const Matrix alone = covariance(condense(f.get(), theta, false), f->prior);
    for (int i = 0; i < n; ++i) {
      // Settled one after the other, without those that follow, states differ from the fit's by their noise, and far
      // corners are left out: a few per cent.
      test::check_between(id.add("column", i), "sigma of the chain over that of the fit", 0.95,
                          std::sqrt(linked(i, i) / joint(i, i)), 1.05);
    }
    // What links say is missing without them: the study of 30 segments lost a third.
    const double lost = std::sqrt((alone.diagonal().array() / joint.diagonal().array()).maxCoeff());
    test::check_true(id.add("lost", lost), "links say nothing", lost > 1.1);
  }
}

/// theta_0 is beside the truth, as a first release is: the epoch's own optimum must come out where the fit's is.
void test_optimum_of_an_epoch_is_that_of_the_fit() {
  double squares = 0;
  int entries = 0;
  for (int seed = 1; seed <= 6; ++seed) {
    SyntheticSession session(device(340 + seed));
    auto f = fit(&session);
    const int n = f->prior.mean.columns();
    const Matrix R = square(f->calibrator.theta_triangle(), n);
    const Matrix joint = (R.transpose() * R).inverse();
    const Calibration<double> at_fit = f->calibrator.theta();
    Calibration<double> beside = at_fit;
    Vector step(n);
    for (int i = 0; i < n; ++i) step(i) = (i % 2 ? 2 : -2) * std::sqrt(joint(i, i));
    add_step(&beside, step.data());
    const Epoch<double> epoch = condense(f.get(), beside, true);
    Epochs<double> epochs;
    epochs.begin(beside, 0) = epoch;
    std::unique_ptr<Fit> alone = std::make_unique<Fit>();
    alone->prior = f->prior;
    alone->calibrator.begin(f->segment, 0, f->prior, beside, MeasurementModel<double>());
    alone->calibrator.take_epochs(&epochs);
    alone->calibrator.run(CalibratorOptions(), &alone->eliminator);
    Vector delta(n);
    difference(at_fit, alone->calibrator.theta(), delta.data());
    for (int i = 0; i < n; ++i) squares += delta(i) * delta(i) / joint(i, i), ++entries;
  }
  // Two sigmas beside, the quadratic brings back to a quarter of one.
  test::check_between(Id(), "distance of the optima, sigmas", 0, std::sqrt(squares / entries), 0.25);
}

Epoch<double> random_epoch(test::Random* random, const Calibration<double>& theta, int segments) {
  Epoch<double> epoch;
  epoch.begin(theta, 3);
  const int n = theta.columns();
  std::vector<double> data(packed_size(n + 1));
  for (int s = 0; s < segments; ++s) {
    for (double& v : data) v = random->normal(1);
    epoch.add(PackedTriangle<double>(data.data(), n + 1), 100, {}, 3, static_cast<std::uint32_t>(s));
  }
  return epoch;
}

/// Merging keeps what is said about theta: the cost differs from the sum of both by a constant.
void test_merged_epochs_say_what_both_said() {
  const SyntheticSession session(device(1));
  const Calibration<double> theta = session.nominal;
  const int n = theta.columns();
  test::Random random(5);
  Calibration<double> other = theta, at = theta;
  Vector step(n);
  // Small steps: differences of rotations add up to first order only.
  for (int i = 0; i < n; ++i) step(i) = random.normal(1e-4);
  add_step(&other, step.data());
  Epoch<double> a = random_epoch(&random, theta, 2), b = random_epoch(&random, other, 3), both = b;
  both.merge(a);
  TEST_ASSERT_EQUAL_INT(5, both.segments);
  double constant = 0;
  for (int trial = 0; trial < 5; ++trial) {
    const double difference = a.cost(at) + b.cost(at) - both.cost(at);
    if (trial == 0) constant = difference;
    test::check_near(Id().add("trial", trial), "cost", constant, difference, 1e-6 * both.cost(at));
    for (int i = 0; i < n; ++i) step(i) = random.normal(1e-4);
    add_step(&at, step.data());
  }
}

void test_a_full_ring_merges_the_oldest() {
  const SyntheticSession session(device(2));
  Epochs<double> epochs;
  test::Random random(6);
  for (int i = 0; i < kEpochs + 2; ++i) epochs.begin(session.nominal, i) = random_epoch(&random, session.nominal, 1);
  TEST_ASSERT_EQUAL_INT(kEpochs, epochs.count());
  TEST_ASSERT_EQUAL_INT(kEpochs + 2, epochs.segments());
  TEST_ASSERT_EQUAL_INT(3, epochs.epoch(0).segments);
}

/// Where the quadratic is believed: up to five of the epoch's own sigmas from theta_0, in each entry; ten, where its
/// segments scatter by four times their sigmas.
void test_an_epoch_holds_near_its_theta() {
  const SyntheticSession session(device(4));
  ThetaPrior<double> prior;
  prior.mean = session.nominal;
  default_prior_sigmas(prior.mean, prior.sigma);
  test::Random random(9);
  Epoch<double> epoch = random_epoch(&random, session.nominal, 5);
  const int n = epoch.columns();
  const Matrix P = covariance(epoch, prior);
  std::vector<double> scratch(packed_size(n + 1));
  for (int i = 0; i < n; ++i) {
    for (const double sigmas : {-5.01, -4.99, 4.99, 5.01, 9.98, 10.02}) {
      const bool scatters = sigmas > 6;
      epoch.pulls = scatters ? Pull<double>{160, 10} : Pull<double>{5, 10};
      Vector step = Vector::Zero(n);
      step(i) = sigmas * std::sqrt(P(i, i));
      Calibration<double> at = session.nominal;
      add_step(&at, step.data());
      test::check_true(Id().add("column", i).add("sigmas", sigmas), "believed or not",
                       epoch.holds_at(at, prior, scratch.data()) == (std::abs(sigmas) < (scatters ? 10 : 5)));
    }
  }
}

/// White rows beside many residuals, in float: what a segment adds must not drown in what is there already.
void test_sums_of_a_day_hold_in_float() {
  const SyntheticSession session(device(3));
  const auto theta = test::cast<float>(session.nominal);
  const int n = theta.columns();
  test::Random random(8);
  auto epoch = std::make_unique<Epoch<float>>();
  epoch->begin(theta, 0);
  std::vector<float> data(packed_size(n + 1));
  for (int s = 0; s < 8000; ++s) {  // segments of 4 s: nine hours
    for (float& v : data) v = static_cast<float>(random.normal(1));
    data.back() = std::sqrt(3000.f);
    epoch->add(PackedTriangle<float>(data.data(), n + 1), 3000, {}, 0, static_cast<std::uint32_t>(s));
  }
  TEST_ASSERT_FLOAT_WITHIN(0.01f * 8000 * 3000, 8000.f * (3000 + n), epoch->information.rho2());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_condensed_chain_tells_what_one_fit_tells);
  RUN_TEST(test_optimum_of_an_epoch_is_that_of_the_fit);
  RUN_TEST(test_merged_epochs_say_what_both_said);
  RUN_TEST(test_a_full_ring_merges_the_oldest);
  RUN_TEST(test_an_epoch_holds_near_its_theta);
  RUN_TEST(test_sums_of_a_day_hold_in_float);
  return UNITY_END();
}
