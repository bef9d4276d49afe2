// segcal replay --passes: each pass starts from the calibration of the one before, and counts the data once.
#include <unity.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "replay/counters.h"
#include "replay/replay.h"
#include "simulate/device.h"
#include "simulate/simulate.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using host::ReplayResult;

struct Case {
  host::SimulationResult session;
  host::Calibration start;  ///< 2 % in f, 10 px in c, 2 deg and 20 mm off
};

const Case& wrong_start() {
  static const Case made = [] {
    Case c;
    host::SimulationOptions options;
    options.seconds = 30;
    options.seed = 5;
    c.session = host::simulate(options);
    c.start = c.session.nominal;
    host::CameraCalibration& camera = c.start.cameras.front();
    camera.intrinsics.head<2>() *= 1.02;
    camera.intrinsics.tail<2>() += Eigen::Vector2d(8, -6);
    camera.R_CI = Eigen::AngleAxisd(2 * M_PI / 180, Eigen::Vector3d(1, 2, 2) / 3).toRotationMatrix() * camera.R_CI;
    camera.p_CI += Eigen::Vector3d(0.012, -0.016, 0);
    return c;
  }();
  return made;
}

ReplayResult replayed(int passes) {
  host::ReplayOptions options;
  options.core.calibration = wrong_start().start;
  options.core.noise = wrong_start().session.recording.imu.noise;
  options.passes = passes;
  return host::replay({wrong_start().session.recording}, options);
}

void test_passes_settle_and_count_once() {
  const ReplayResult one = replayed(1), many = replayed(6);
  TEST_ASSERT_EQUAL_STRING("calibrated", many.result.status.c_str());
  TEST_ASSERT_EQUAL_UINT(1, one.passes.size());
  TEST_ASSERT_GREATER_THAN_UINT(1, many.passes.size());
  // The first pass is the single one, and it is the one that moves: from 40 sigmas and more to a fraction of one.
  TEST_ASSERT_TRUE(one.passes[0].step_sigmas == many.passes[0].step_sigmas);
  TEST_ASSERT_TRUE(many.passes[0].step_sigmas > 20);
  TEST_ASSERT_TRUE_MESSAGE(many.passes.back().step_sigmas < 0.5,
                           host::in_words(many.passes.back(), many.passes.size()).c_str());
  TEST_ASSERT_TRUE(many.passes.back().settled() || many.passes.size() == 6);
  // All else is of the last pass, as of a replay from there.
  TEST_ASSERT_EQUAL_UINT(1, many.calibrations.size());
  TEST_ASSERT_UINT_WITHIN(one.trajectory.size() / 5, one.trajectory.size(), many.trajectory.size());
  for (const char* counter : {"frames_used", "features_used", "segments_closed"}) {
    const std::uint32_t in_one = host::count_of(one.counters, counter);
    TEST_ASSERT_UINT_WITHIN_MESSAGE(in_one / 5, in_one, host::count_of(many.counters, counter), counter);
  }
  for (const host::CoreSegment& s : many.segments) TEST_ASSERT_EQUAL_UINT(0, s.session);
  for (const host::CoreKept& k : many.kept) TEST_ASSERT_EQUAL_UINT(0, k.segment.session);
  std::map<std::string, double> truth;
  for (const auto& p : host::sim::named_parameters(wrong_start().session.truth, true)) truth[p.name] = p.value;
  for (std::size_t i = 0; i < many.result.parameters.size(); ++i) {
    const host::CoreParameter &p = many.result.parameters[i], &single = one.result.parameters[i];
    TEST_ASSERT_TRUE(p.initial == single.initial && p.prior_sigma == single.prior_sigma);
    // Data that were counted again in each pass would have 0.4 to 0.7
    // times the sigma; other segments that are kept change it by less.
    TEST_ASSERT_TRUE_MESSAGE(p.sigma > 0.8 * single.sigma, p.name.c_str());
    TEST_ASSERT_TRUE_MESSAGE(std::abs(p.value - truth.at(p.name)) < 5 * p.sigma, p.name.c_str());
  }
}

/// A pass that gives no calibration ends it: there is nothing to go on from.
void test_nothing_to_go_on_from() {
  host::ReplayOptions options;
  options.core.calibration = wrong_start().session.nominal;
  options.core.noise = wrong_start().session.recording.imu.noise;
  options.passes = 5;
  host::Recording brief = wrong_start().session.recording;
  brief.cameras[0].frames.resize(20);  // two seconds
  const ReplayResult result = host::replay({brief}, options);
  TEST_ASSERT_EQUAL_UINT(1, result.passes.size());
  TEST_ASSERT_EQUAL_STRING("insufficient", result.result.status.c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_passes_settle_and_count_once);
  RUN_TEST(test_nothing_to_go_on_from);
  return UNITY_END();
}
