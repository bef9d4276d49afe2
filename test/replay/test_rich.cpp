// Simulated devices, shaken on purpose for 60 s: is the truth
// found, and are the sigmas honest? Each device is drawn anew.
//
// 20 devices by default, 400 where SEGCAL_LONG is set: the mean of 20 squares scatters by 0.32 even if all is right, so
// that the limits 0.7 to 1.4 for each parameter need the longer run.
#include <unity.h>

#include <algorithm>
#include <vector>

#include "../support/cases.h"
#include "simulated_replay.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

/// A parameter over all devices.
struct Statistic {
  double squares = 0, largest_sigma = 0;
  int n = 0;
  double mean() const { return squares / n; }
};

struct Study {
  std::map<std::string, Statistic> parameter;
  std::vector<double> chi2_per_dof;
  std::vector<Id> not_calibrated;
};

int devices() { return test::long_run() ? 400 : 20; }

void add_device(int seed, Study* study) {
  const host::SimulationResult session = test::simulated("rich", 60, static_cast<std::uint64_t>(seed));
  const host::CoreResult result = test::replayed(session).result;
  if (result.status != "calibrated") study->not_calibrated.push_back(Id().add("seed", seed));
  study->chi2_per_dof.push_back(result.chi2 / result.dof);
  const auto errors = test::normalised_errors(session, result);
  for (const host::CoreParameter& p : result.parameters) {
    Statistic& s = study->parameter[p.name];
    s.squares += errors.at(p.name) * errors.at(p.name);
    s.largest_sigma = std::max(s.largest_sigma, p.sigma);
    ++s.n;
    // 26 parameters on 400 devices: beyond 6 sigma is once in 50000 such runs.
    test::check_between(Id().add("seed", seed).add("parameter", p.name), "error / sigma", -6, errors.at(p.name), 6);
  }
}

/// All devices, once for all tests of this program.
const Study& study() {
  static const Study result = [] {
    Study s;
    for (int seed = 1; seed <= devices(); ++seed) {
      if (test::selected(Id().add("seed", seed).text())) add_device(seed, &s);
    }
    return s;
  }();
  return result;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

void test_every_device_is_calibrated() {
  if (!study().not_calibrated.empty()) test::fail_case(study().not_calibrated.front(), "not calibrated");
}

void test_the_fit_is_as_good_as_the_noise() {
  std::printf("chi2/dof: mean %.4f, %.4f to %.4f over %d devices\n", mean(study().chi2_per_dof),
              *std::min_element(study().chi2_per_dof.begin(), study().chi2_per_dof.end()),
              *std::max_element(study().chi2_per_dof.begin(), study().chi2_per_dof.end()), devices());
  test::check_between(Id().add("check", "chi2"), "mean chi2/dof", 0.95, mean(study().chi2_per_dof), 1.05);
}

void test_errors_are_as_large_as_the_sigmas_say() {
  // One parameter of 26 may leave these quantiles of chi-square / n by chance once in 100 runs: 0.01 / 52 at each end.
  const double low = test::long_run() ? 0.7 : 0.238, high = test::long_run() ? 1.4 : 2.522;
  double all = 0;
  for (const auto& [name, s] : study().parameter) {
    std::printf("%-14s mean (error/sigma)^2 %.2f, largest sigma %.3g\n", name.c_str(), s.mean(), s.largest_sigma);
    all += s.mean() / static_cast<double>(study().parameter.size());
  }
  for (const auto& [name, s] : study().parameter) {
    test::check_between(Id().add("check", "honest").add("parameter", name), "mean (error/sigma)^2", low, s.mean(),
                        high);
  }
  std::printf("all parameters: mean (error/sigma)^2 %.3f\n", all);
  test::check_between(Id().add("check", "honest").add("parameter", "all"), "mean (error/sigma)^2", 0.7, all, 1.4);
}

void test_sigmas_are_small() {
  std::map<std::string, double> sigma;
  for (const auto& [name, s] : study().parameter) sigma[name] = s.largest_sigma;
  const auto largest = test::largest_by_kind(sigma);
  test::check_between(Id().add("check", "f"), "largest sigma, px", 0, largest.at("cam0.f"), 0.15);
  test::check_between(Id().add("check", "p_CI"), "largest sigma, m", 0, largest.at("cam0.p_CI"), 0.002);
  test::check_between(Id().add("check", "gyro_scale"), "largest sigma", 0, largest.at("gyro.s"), 6e-4);
}

/// Profile mcu averages 200 Hz to 100 Hz, so that an image waits for its
/// samples until after the next ones: its state is written all the same.
void test_each_state_is_written_where_images_wait() {
  const host::SimulationResult session = test::simulated("rich", 20, 3);
  const host::ReplayResult out = test::replayed(session, "mcu");
  // 201 images; eight before the start in motion, which takes effect half a second later, and the last one, whose
  // samples never come.
  TEST_ASSERT_UINT_WITHIN(10, 185, out.trajectory.size());
  for (std::size_t i = 1; i < out.trajectory.size(); ++i)
    TEST_ASSERT_TRUE(out.trajectory[i].t_ns > out.trajectory[i - 1].t_ns);
  TEST_ASSERT_TRUE(out.timing.vio_ms_median > 0);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_every_device_is_calibrated);
  RUN_TEST(test_the_fit_is_as_good_as_the_noise);
  RUN_TEST(test_errors_are_as_large_as_the_sigmas_say);
  RUN_TEST(test_sigmas_are_small);
  RUN_TEST(test_each_state_is_written_where_images_wait);
  return UNITY_END();
}
