// A chain of segments condensed one by one against the same segments in one fit.
#include <memory>

#include "calibration/calibrator.h"
#include "epoch_cases.h"

using namespace SEGCAL_NS;
using test::covariance;
using test::device;
using test::Id;
using test::Matrix;
using test::square;
using test::SyntheticSession;
using test::Vector;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// A fit of a whole session, which stands at its optimum.
struct Fit {
  Calibrator<double> calibrator;
  SegmentEliminator<double> eliminator;
  ThetaPrior<double> prior;
  Segment<double>* segment[kMaxSegments];
  int n = 0;
};

std::unique_ptr<Fit> fit(SyntheticSession* session) {
  auto f = std::make_unique<Fit>();
  for (auto& s : session->segments) f->segment[f->n++] = s.get();
  f->prior.mean = session->nominal;
  default_prior_sigmas(f->prior.mean, f->prior.sigma);
  f->calibrator.begin(f->segment, f->n, f->prior, f->prior.mean, MeasurementModel<double>());
  f->calibrator.run(CalibratorOptions(), &f->eliminator);
  return f;
}

/// Condenses the segments at theta, in their order; each `rounds` times, from where it is.
Epoch<double> condense(Fit* f, const Calibration<double>& theta, bool linked, int rounds = 1) {
  Epoch<double> epoch;
  Condenser<double> condenser;
  epoch.begin(theta, 0);
  for (int i = 0; i < f->n; ++i) {
    condenser.restart();
    if (!linked) condenser.break_chain();
    CondenseMemory<double> memory;
    for (int round = 0; round < rounds; ++round) {
      memory = f->calibrator.begin_condensing(&f->eliminator);
      while (!condenser.step(f->segment[i], MeasurementModel<double>(), memory, &epoch, round > 0)) {
      }
    }
    TEST_ASSERT_TRUE(condenser.condensed());
    condenser.take(f->segment[i], memory, {}, &epoch);
  }
  return epoch;
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

/// Two steps from the fit's optimum are enough; six more change nothing, the links to the segments before included.
void test_what_is_settled_tells_the_same_again() {
  for (int seed = 1; seed <= 3; ++seed) {
    const Id id = Id().add("seed", seed);
    SyntheticSession session(device(320 + seed)), same(device(320 + seed));
    auto f = fit(&session), g = fit(&same);
    const int n = f->prior.mean.columns();
    const Calibration<double> theta = f->calibrator.theta();
    Epoch<double> once = condense(f.get(), theta, true), again = condense(g.get(), theta, true, 4);
    const Matrix R = square(once.information.triangle(), n), Q = square(again.information.triangle(), n);
    const Matrix A = R.transpose() * R, B = Q.transpose() * Q;
    Vector d(n), e(n);
    for (int i = 0; i < n; ++i) d(i) = once.information.triangle()(i, n), e(i) = again.information.triangle()(i, n);
    const Vector own = A.diagonal().cwiseSqrt(), pull = (R.transpose() * d - Q.transpose() * e).cwiseQuotient(own);
    // The two steps end within a hundredth of a sigma of the states.
    for (int i = 0; i < n; ++i) {
      test::check_near(Id(id).add("column", i), "pull, sigmas", 0, pull(i), 0.05);
      for (int c = 0; c < n; ++c)
        test::check_near(Id(id).add("row", i).add("column", c), "information", A(i, c) / own(i) / own(c),
                         B(i, c) / own(i) / own(c), 2e-3);
    }
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

/// Worst entry's distance between the optimum of the epoch with the prior and `at`, in sigmas of both together.
double worst_distance(const Epoch<double>& epoch, const ThetaPrior<double>& prior, const Calibration<double>& at) {
  const int n = epoch.columns();
  Epochs<double> epochs;
  epochs.begin(epoch.theta, 0) = epoch;
  auto alone = std::make_unique<Fit>();
  alone->calibrator.begin(alone->segment, 0, prior, epoch.theta, MeasurementModel<double>());
  alone->calibrator.take_epochs(&epochs);
  alone->calibrator.run(CalibratorOptions(), &alone->eliminator);
  const Matrix P = covariance(epoch, prior);
  Vector delta(n);
  difference(at, alone->calibrator.theta(), delta.data());
  return delta.cwiseQuotient(P.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff();
}

/// theta_0 a fifth of the prior's sigmas beside the fit, in any direction: some twenty of the epoch's own sigmas.
/// Widened by what the bound is exceeded by, its optimum is the fit's within its sigmas.
void test_a_far_epoch_tells_as_much_as_it_is_right() {
  double untouched = 0;
  for (int seed = 1; seed <= 6; ++seed) {
    const Id id = Id().add("seed", seed);
    SyntheticSession session(device(360 + seed));
    auto f = fit(&session);
    const int n = f->prior.mean.columns();
    const Calibration<double> at_fit = f->calibrator.theta();
    Calibration<double> beside = at_fit;
    test::Random random(static_cast<std::uint32_t>(seed));
    Vector step(n);
    for (int i = 0; i < n; ++i) step(i) = random.normal(0.2 * f->prior.sigma[i]);
    add_step(&beside, step.data());
    Epoch<double> epoch = condense(f.get(), beside, true);
    untouched += worst_distance(epoch, f->prior, at_fit) / 6;
    std::vector<double> scratch(packed_size(n + 1));
    const double bent = epoch.bent_at(at_fit, f->prior, scratch.data());
    test::check_between(id, "beyond the bound", 2, bent, 100);
    TEST_ASSERT_TRUE(epoch.widen_for(at_fit, f->prior, scratch.data()));
    // The study of 224 cases has nine in ten within 0.8.
    test::check_between(id, "worst entry, sigmas", 0, worst_distance(epoch, f->prior, at_fit), 1.2);
  }
  test::check_between(Id(), "as it is, sigmas", 2, untouched, 30);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_condensed_chain_tells_what_one_fit_tells);
  RUN_TEST(test_what_is_settled_tells_the_same_again);
  RUN_TEST(test_optimum_of_an_epoch_is_that_of_the_fit);
  RUN_TEST(test_a_far_epoch_tells_as_much_as_it_is_right);
  return UNITY_END();
}
