// The algebra of epochs: sums, merging, and how far they hold.
#include <memory>
#include <vector>

#include "../support/cast.h"
#include "epoch_cases.h"

using namespace SEGCAL_NS;
using test::covariance;
using test::device;
using test::Id;
using test::Matrix;
using test::SyntheticSession;
using test::Vector;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

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

/// Of what random_epoch says, so much that each entry is told to a few hundredths of the prior's sigma.
Epoch<double> telling_epoch(test::Random* random, const Calibration<double>& theta, const ThetaPrior<double>& prior) {
  Epoch<double> epoch = random_epoch(random, theta, 20);
  const int n = epoch.columns();
  PackedTriangle<double> T = epoch.information.triangle();
  for (int i = 0; i < n; ++i) {
    for (int c = i; c < n; ++c) T.row(i)[c] *= 10 / prior.sigma[c];
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

/// How far theta is from where the quadratic is believed: delta^2 up to 1.5 of the prior's sigma times the epoch's own,
/// in each entry; four times as much, where its segments scatter by four times their sigmas.
void test_an_epoch_holds_near_its_theta() {
  const SyntheticSession session(device(4));
  ThetaPrior<double> prior;
  prior.mean = session.nominal;
  default_prior_sigmas(prior.mean, prior.sigma);
  test::Random random(9);
  Epoch<double> epoch = telling_epoch(&random, session.nominal, prior);
  const int n = epoch.columns();
  const Matrix P = covariance(epoch, prior);
  std::vector<double> scratch(packed_size(n + 1));
  for (int i = 0; i < n; ++i) {
    for (const double bent : {-1.51, 0.3, 1.5, 6.0, 12.0}) {
      const bool scatters = bent > 3;
      epoch.pulls = scatters ? Pull<double>{160, 10} : Pull<double>{5, 10};
      Vector step = Vector::Zero(n);
      step(i) = std::copysign(std::sqrt(std::abs(bent) * prior.sigma[i] * std::sqrt(P(i, i))), bent);
      Calibration<double> at = session.nominal;
      add_step(&at, step.data());
      test::check_near(Id().add("column", i).add("bent", bent), "of the bound", std::abs(bent) / (scatters ? 6 : 1.5),
                       epoch.bent_at(at, prior, scratch.data()), 1e-6);
    }
  }
}

/// Widened once, an epoch is right where theta is: later calibrations there must not widen it again, however far from
/// theta_0 that is.
void test_widening_ends() {
  const SyntheticSession session(device(5));
  ThetaPrior<double> prior;
  prior.mean = session.nominal;
  default_prior_sigmas(prior.mean, prior.sigma);
  test::Random random(10);
  const Epoch<double> drawn = telling_epoch(&random, session.nominal, prior);
  const int n = drawn.columns();
  std::vector<double> scratch(packed_size(n + 1));
  for (const double far : {0.5, 1.0, 3.0}) {  // of the prior's sigmas
    for (int i = 0; i < n; ++i) {
      Epoch<double> epoch = drawn;
      Vector step = Vector::Zero(n);
      step(i) = far * prior.sigma[i];
      Calibration<double> at = session.nominal;
      add_step(&at, step.data());
      int times = 0;
      for (; times < 20 && epoch.widen_for(at, prior, scratch.data()); ++times) {
      }
      test::check_between(Id().add("column", i).add("far", far), "times", 1, times, 6);
    }
  }
}

/// Roundings of a held entry, whose prior is tiny, are no distance.
void test_a_held_entry_widens_nothing() {
  const SyntheticSession session(device(6));
  ThetaPrior<float> prior;
  prior.mean = test::cast<float>(session.nominal);
  default_prior_sigmas(prior.mean, prior.sigma);
  const int n = prior.mean.columns();
  for (int i = 0; i < 3; ++i) prior.sigma[i] = 1e-9f;  // the least that a configuration may state
  Epoch<float> epoch;
  epoch.begin(prior.mean, 0);
  test::Random random(11);
  std::vector<float> data(packed_size(n + 1)), scratch(packed_size(n + 1));
  for (float& v : data) v = static_cast<float>(random.normal(1));
  epoch.add(PackedTriangle<float>(data.data(), n + 1), 100, {}, 0, 0);
  Calibration<float> at = prior.mean;
  float step[kMaxTheta] = {};
  for (int k = 0; k < 30; ++k) {
    step[k % 3] = 1e-7f;  // of a rotation in float
    add_step(&at, step);
    step[k % 3] = 0;
  }
  TEST_ASSERT_FALSE(epoch.widen_for(at, prior, scratch.data()));
}

/// Of an epoch that has just begun there is nothing to be widened.
void test_an_empty_epoch_is_not_widened() {
  const SyntheticSession session(device(7));
  ThetaPrior<double> prior;
  prior.mean = session.nominal;
  default_prior_sigmas(prior.mean, prior.sigma);
  Epoch<double> epoch;
  epoch.begin(session.nominal, 0);
  Vector step = Vector::Constant(epoch.columns(), 0.2);
  Calibration<double> at = session.nominal;
  add_step(&at, step.data());
  std::vector<double> scratch(packed_size(epoch.columns() + 1));
  TEST_ASSERT_FALSE(epoch.widen_for(at, prior, scratch.data()));
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
  RUN_TEST(test_merged_epochs_say_what_both_said);
  RUN_TEST(test_a_full_ring_merges_the_oldest);
  RUN_TEST(test_an_epoch_holds_near_its_theta);
  RUN_TEST(test_widening_ends);
  RUN_TEST(test_a_held_entry_widens_nothing);
  RUN_TEST(test_an_empty_epoch_is_not_widened);
  RUN_TEST(test_sums_of_a_day_hold_in_float);
  return UNITY_END();
}
