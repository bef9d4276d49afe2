// Whose deadlines they are, for a processor that has time for one slice a sample: with windows that allow it, every
// schedule of the background gives the same bits.
#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

// A score takes up to 1180 slices (320 in profile mcu): a segment lasts so many samples. A
// calibration takes up to 56,000 from three and four segments in profile mobile, 35,000 from
// eight in mcu: so many segments its window has. Where it starts in motion, profile mcu does
// that in slices that have half a second (SEGCAL_START_DELAY_MS): it starts at rest.
constexpr bool kMcu = SEGCAL_PROFILE == SEGCAL_PROFILE_MCU;
constexpr double kSegmentSeconds = 6, kRestSeconds = 2;
constexpr int kSegments = kMcu ? 8 : 3;
constexpr int kWindow = kMcu ? 30 : 48;
constexpr int kSeconds = kMcu ? 450 : 640;
/// the first one, from 25 or 55 s on, has taken effect by then
constexpr std::size_t kRequest = (kMcu ? 240 : 320) * 200;

const SyntheticStream& stream() {
  static const SyntheticStream instance(7, kSeconds, kRestSeconds);
  return instance;
}

struct Schedule {
  int slices, every;  ///< so many, after each `every`-th sample
};

struct Run {
  std::uint64_t on_the_way, at_the_end;
  segcal_counters_t counters;
};

Run run(const Schedule& schedule) {
  Storage storage(0xFF);
  segcal_config_t config = SyntheticStream::config();
  config.keep_segments = kSegments;
  config.segment_s = kSegmentSeconds;
  config.calibration_window = kWindow;
  segcal_t* device = create(&storage, config);
  segcal_work_when_due(device, 0);  // as segcal_create leaves it
  Run out{14695981039346656037ull, 0, {}};
  for (std::size_t i = 0; i < stream().imu.size(); ++i) {
    if (i == kRequest) TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_request_calibration(device));
    TEST_ASSERT_GREATER_OR_EQUAL_INT(0, segcal_push_imu(device, &stream().imu[i]));
    if (i % 20 == 0) {
      push_frame(device, stream().frames[i / 20], Way::tracks);
      out.on_the_way = (out.on_the_way ^ segcal_result_hash(device)) * 1099511628211ull;
    }
    if (i % std::size_t(schedule.every) == 0) segcal_background(device, schedule.slices);
  }
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_counters(device, &out.counters));
  segcal_flush(device);
  out.at_the_end = segcal_result_hash(device);
  return out;
}

void test_one_hash() {
  const Run expected = run({1000000, 1});
  TEST_ASSERT_GREATER_OR_EQUAL_UINT(2, expected.counters.calibrations_published);
  for (const Schedule& schedule : {Schedule{1, 1}, {2, 1}, {8, 1}, {32, 1}, {100, 100}, {1600, 200}}) {
    const Id id = Id().add("slices", schedule.slices).add("each so many samples", schedule.every);
    const Run now = run(schedule);
    check_near(id, "work that was late", 0, now.counters.slices_late, 0);
    check_true(id, "another hash on the way", now.on_the_way == expected.on_the_way);
    check_true(id, "another hash at the end", now.at_the_end == expected.at_the_end);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc - 1, argv + 1);
  UNITY_BEGIN();
  RUN_TEST(test_one_hash);
  return UNITY_END();
}
