// The sandwich covariance on linear problems with known noise: as the model's where residuals are noise, wider where
// segments have errors of their own.
#include "../diagnosis/linear_problem.h"
#include "../support/cases.h"
#include "review/segment_scatter.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

/// Mean (error/sigma)^2 with and without the factor over 200
/// recordings of eight segments, and how often any sigma was widened.
struct Study {
  double with = 0, without = 0, widened = 0, pooled = 0;
};

Study study_of(double shift_of_segments) {
  constexpr int runs = 200;
  Study out;
  for (std::uint32_t seed = 1; seed <= runs; ++seed) {
    test::Random random(seed);
    test::LinearRecording recording;
    recording.segments = 8;
    recording.truth = Eigen::VectorXd();
    recording.outside = [&](int, const Eigen::MatrixXd& J, Eigen::VectorXd* r) {
      *r += shift_of_segments * J * random.matrix(6, 1);
    };
    const host::diagnosis::Problem problem = test::problem_of(recording, &random);
    const auto s = host::diagnosis::solve(host::diagnosis::with_prior(problem.all, problem.prior));
    const auto scatter = host::review::scatter_of_segments(problem, Eigen::MatrixXd::Identity(6, 6), 1);
    out.pooled += scatter.pooled / runs;
    out.widened += (scatter.variance_factor.array() > 1).any() ? 1.0 / runs : 0;
    for (int i = 0; i < 6; ++i) {
      const double z2 = s.x(i) * s.x(i) / s.covariance(i, i);
      out.without += z2 / (6 * runs);
      out.with += z2 / scatter.variance_factor(i) / (6 * runs);
    }
  }
  return out;
}

/// 1200 squares of unit variance: their mean is 1 to 0.04 (one sigma). The pull's ratio over 48 degrees of freedom
/// likewise.
void test_noise_is_left_as_it_is() {
  const Study s = study_of(0);
  test::check_between(Id(), "mean z^2", 0.85, s.with, 1.15);
  test::check_between(Id(), "pooled", 0.9, s.pooled, 1.1);
  test::check_between(Id(), "recordings with a wider sigma", 0, s.widened, 0.03);  // one in 1000, twice
}

/// Each segment's theta is off by 0.3 in each entry, where it knows it to 0.09: sigmas of the mean are 3.3 times too
/// small. From eight segments a variance is known to a half, so that 1/variance is too large by some tenths on average.
void test_segments_that_disagree_widen_the_sigmas() {
  const Study s = study_of(0.3);
  test::check_between(Id(), "mean z^2 of the model", 7, s.without, 18);
  test::check_between(Id(), "mean z^2 of the sandwich", 0.7, s.with, 2);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_noise_is_left_as_it_is);
  RUN_TEST(test_segments_that_disagree_widen_the_sigmas);
  return UNITY_END();
}
