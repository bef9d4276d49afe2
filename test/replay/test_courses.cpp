// A device whose focal length changes a little in each session: no segment contradicts what is known by much, and the
// answer is a mean over sessions. It is named, and the sigmas hold it.
#include <algorithm>

#include "../support/cases.h"
#include "simulated_replay.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// px; a session alone tells it to 0.12.
constexpr double kPerSession = 0.15;
constexpr int kSessions = 5;

host::SimulationResult session(int k, double focal_px) {
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = 40;
  options.seed = 77010 + static_cast<std::uint64_t>(k);
  options.device_seed = 7701;
  options.change_device = [focal_px](host::Calibration& device) {
    device.cameras[0].intrinsics[0] += focal_px;
    device.cameras[0].intrinsics[1] += focal_px;
  };
  return host::simulate(options);
}

host::ReplayResult replay_of(double per_session, host::SimulationResult* last) {
  std::vector<host::Recording> recordings;
  for (int k = 0; k < kSessions; ++k) {
    *last = session(k, per_session * k);
    recordings.push_back(last->recording);
  }
  host::ReplayOptions replay;
  replay.core.calibration = last->nominal;
  replay.core.noise = last->recording.imu.noise;
  replay.core.condense = replay.core.multi_session = true;
  return host::replay(recordings, replay);
}

double largest_error(const host::SimulationResult& truth, const host::CoreResult& result) {
  double largest = 0;
  for (const auto& [name, error] : test::normalised_errors(truth, result)) largest = std::max(largest, std::abs(error));
  return largest;
}

void test_what_ages_is_named() {
  host::SimulationResult last;
  const host::ReplayResult out = replay_of(kPerSession, &last);
  TEST_ASSERT_EQUAL_size_t(1, out.result.course.courses.size());
  TEST_ASSERT_EQUAL_STRING("trend", out.result.course.courses[0].c_str());
  TEST_ASSERT_EQUAL_INT(kSessions, out.result.course.sessions);
  for (std::size_t i = 0; i < out.result.parameters.size(); ++i) {
    const bool focal = out.result.parameters[i].name == "cam0.fx" || out.result.parameters[i].name == "cam0.fy";
    const test::Id id = test::Id().add("parameter", out.result.parameters[i].name);
    const double rate = out.result.course.rate[i], sigma = out.result.course.sigma[i];
    if (focal) test::check_between(id, "rate beside the truth, in sigmas", -4, (rate - kPerSession) / sigma, 4);
    if (!focal) test::check_true(id, "it has a rate", sigma == 0);
  }
  // The lag is in the variances and in no correlation, else directions of the two would be far too narrow.
  const std::vector<double>& C = out.result.covariance;
  const std::size_t n = out.result.parameters.size(), fx = 6, fy = 7;
  TEST_ASSERT_EQUAL_STRING("cam0.fx", out.result.parameters[fx].name.c_str());
  const double correlation = C[fx * n + fy] / std::sqrt(C[fx * n + fx] * C[fy * n + fy]);
  test::check_between(test::Id(), "correlation of fx and fy", 0, correlation, 0.5);
  // What was released is a mean from some change on; with what the lag adds, its error is not beyond 4 sigmas.
  TEST_ASSERT_EQUAL_STRING_MESSAGE("calibrated", out.result.status.c_str(), out.cause.c_str());
  test::check_between(test::Id(), "error", 0, largest_error(last, out.result), 4);
}

void test_what_stays_is_not() {
  host::SimulationResult last;
  const host::ReplayResult out = replay_of(0, &last);
  TEST_ASSERT_EQUAL_STRING_MESSAGE("calibrated", out.result.status.c_str(), out.cause.c_str());
  TEST_ASSERT_EQUAL_size_t(1, out.result.course.courses.size());
  TEST_ASSERT_EQUAL_STRING("steps", out.result.course.courses[0].c_str());
  TEST_ASSERT_EQUAL_STRING("", out.result.course.rate_of.c_str());
  TEST_ASSERT_GREATER_OR_EQUAL_size_t(kSessions - 1, out.result.history.size());
  test::check_between(test::Id(), "error", 0, largest_error(last, out.result), 4);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_what_ages_is_named);
  RUN_TEST(test_what_stays_is_not);
  return UNITY_END();
}
