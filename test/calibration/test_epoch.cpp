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
  Epoch<double> epoch = random_epoch(&random, session.nominal, 5);
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
  RUN_TEST(test_sums_of_a_day_hold_in_float);
  return UNITY_END();
}
