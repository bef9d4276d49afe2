// The study of faults: each kind changes the recording in the way that it says, and the gathering counts what is wrong.
#include <unity.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "experiments/registry.h"
#include "recording.h"
#include "simulate/fault_kinds.h"
#include "simulate/simulate.h"
#include "simulate/spoil.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace host;
using namespace host::experiments;
using namespace host::sim;

const Recording& clean() {
  static const Recording recording = [] {
    SimulationOptions options;
    options.seconds = 8;
    return simulate(options).recording;
  }();
  return recording;
}

Recording spoilt(const std::string& kind, std::uint64_t seed = 1) {
  Recording r = clean();
  fault_kind(kind).spoil(r, seed);
  return r;
}

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }  // NaN as well

bool same(const Recording& a, const Recording& b) {
  const auto samples = [](const ImuSample& x, const ImuSample& y) {
    bool equal = x.t_ns == y.t_ns;
    for (std::size_t i = 0; i < 3; ++i) equal = equal && same(x.gyro[i], y.gyro[i]) && same(x.accel[i], y.accel[i]);
    return equal;
  };
  const auto points = [](const TrackPoint& x, const TrackPoint& y) {
    return x.track_id == y.track_id && x.u == y.u && x.v == y.v;
  };
  const auto frames = [&](const Frame& x, const Frame& y) {
    return x.t_ns == y.t_ns && std::equal(x.points.begin(), x.points.end(), y.points.begin(), y.points.end(), points);
  };
  const auto &fa = a.cameras[0].frames, &fb = b.cameras[0].frames;
  return std::equal(a.imu.samples.begin(), a.imu.samples.end(), b.imu.samples.begin(), b.imu.samples.end(), samples) &&
         std::equal(fa.begin(), fa.end(), fb.begin(), fb.end(), frames);
}

void test_every_kind_changes_the_recording_and_the_seed_says_how() {
  std::set<std::string> names;
  for (const FaultKind& kind : fault_kinds()) {
    TEST_ASSERT_TRUE_MESSAGE(names.insert(kind.name).second, kind.name);
    const bool in_the_log = std::string(kind.name) != "none" && kind.effect.empty();
    TEST_ASSERT_TRUE_MESSAGE(same(spoilt(kind.name), clean()) != in_the_log, kind.name);
    TEST_ASSERT_TRUE_MESSAGE(same(spoilt(kind.name), spoilt(kind.name)), kind.name);
  }
}

double share_of_samples(const Recording& r) {
  return static_cast<double>(r.imu.samples.size()) / static_cast<double>(clean().imu.samples.size());
}

void test_sizes() {
  // 1600 samples: a share of 0.1 scatters by 0.0075.
  TEST_ASSERT_DOUBLE_WITHIN(0.03, 0.9, share_of_samples(spoilt("imu_dropped_10")));
  TEST_ASSERT_DOUBLE_WITHIN(0.04, 0.7, share_of_samples(spoilt("imu_dropped_30")));
  TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.75, share_of_samples(spoilt("imu_rate_halved")));
  TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.02, share_of_samples(spoilt("duplicates")));
  const auto not_finite = [](const Recording& r) {
    return std::count_if(r.imu.samples.begin(), r.imu.samples.end(),
                         [](const ImuSample& s) { return std::isnan(s.accel[0] + s.accel[1] + s.accel[2]); });
  };
  TEST_ASSERT_INT_WITHIN(16, 16, not_finite(spoilt("not_a_number")));  // 1 %, to four standard deviations
  TEST_ASSERT_TRUE(not_finite(spoilt("not_a_number")) > 0);
  const Recording half = spoilt("half_resolution");
  TEST_ASSERT_EQUAL_DOUBLE(0.5 * clean().cameras[0].frames[3].points[2].u, half.cameras[0].frames[3].points[2].u);
  const Recording covered = spoilt("camera_covered");
  const auto empty = std::count_if(covered.cameras[0].frames.begin(), covered.cameras[0].frames.end(),
                                   [](const Frame& f) { return f.points.empty(); });
  TEST_ASSERT_INT_WITHIN(1, 30, empty);  // 3 s at 10 Hz
}

CellResult cell(const char* kind, int seed, const char* status, double largest, const Json& counters) {
  return {{{"kind", kind}, {"seed", seed}},
          {{"status", status},
           {"largest", largest},
           {"largest_of", "cam0.fx"},
           {"chi2_per_dof", 1.0},
           {"seconds", 1.0},
           {"said",
            {{"counters", counters},
             {"suspects", Json::array()},
             {"clock", nullptr},
             {"cause", status == std::string("failed") ? "why" : ""}}}}};
}

void test_what_is_counted() {
  const Findings found =
      faults_gather({cell("none", 1, "calibrated", 2, {{"imu_gaps", 1}}),
                     cell("imu_gaps", 1, "calibrated", 5.1, {{"imu_gaps", 1}}),  // no more gaps than without the fault
                     cell("imu_gaps", 2, "calibrated", 4.9, {{"imu_gaps", 3}}),
                     cell("not_a_number", 1, "failed", 50, {{"imu_not_finite", 3}})});  // refused: no wrong answer
  TEST_ASSERT_EQUAL_DOUBLE(1, found.limits[0].value);
  TEST_ASSERT_EQUAL_DOUBLE(1, found.limits[1].value);
  TEST_ASSERT_EQUAL_size_t(1, found.tables[1].rows.size());
  TEST_ASSERT_EQUAL_STRING("imu_gaps", found.tables[1].rows[0][0].get<std::string>().c_str());
  const CellResult nan = cell("imu_gaps", 3, "calibrated", 1, Json::object());
  CellResult broken = nan;
  broken.result["largest"] = nullptr;  // NaN, as JSON has it
  TEST_ASSERT_EQUAL_DOUBLE(1, faults_gather({broken}).limits[0].value);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_every_kind_changes_the_recording_and_the_seed_says_how);
  RUN_TEST(test_sizes);
  RUN_TEST(test_what_is_counted);
  return UNITY_END();
}
