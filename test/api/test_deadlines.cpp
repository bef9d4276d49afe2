// Whose deadlines they are: no call that feeds does background work, whatever the background missed; what is late is
// dropped or put off by rules that do not ask when the slices were done.
#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

const SyntheticStream& thirty() { return long_stream<30>(); }

segcal_progress_t progress_of(const segcal_t* device) {
  segcal_progress_t p{};
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_progress(device, &p));
  return p;
}
segcal_counters_t counters_of(const segcal_t* device) {
  segcal_counters_t c{};
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_counters(device, &c));
  return c;
}

/// As segcal_create leaves it.
segcal_t* create_with_deadlines(Storage* storage, const segcal_config_t& config) {
  segcal_t* device = create(storage, config);
  segcal_work_when_due(device, 0);
  return device;
}

/// Two calibrations: one of its own after 6 s, one that is asked for at 16 s.
segcal_config_t config() {
  segcal_config_t c = SyntheticStream::config();
  c.keep_segments = 3;
  return c;
}
constexpr std::size_t kRequest = 3310;  ///< while a segment is scored, or after that: it must not matter

/// When the background works: `slices` after each `every`-th sample.
struct Schedule {
  int slices, every;
};

/// The calls that feed, one after the other, and what was seen at them.
class Feed {
 public:
  explicit Feed(segcal_t* device) : device_(device) {}

  /// Sample i, and its image where there is one.
  void sample(std::size_t i, const Id& id) {
    begin();
    TEST_ASSERT_GREATER_OR_EQUAL_INT(0, segcal_push_imu(device_, &thirty().imu[i]));
    end(id);
    if (i % 20 != 0) return;
    begin();
    push_frame(device_, thirty().frames[i / 20], Way::tracks);
    end(id);
    hash = (hash ^ segcal_result_hash(device_)) * 1099511628211ull;
  }

  std::vector<bool> late;                        ///< of each call: what it found undone
  const std::vector<bool>* repeat = nullptr;     ///< calls at which work is to be late
  std::uint64_t hash = 14695981039346656037ull;  ///< over the hashes after each image
  std::uint32_t most_slices = 0;                 ///< done by a call that feeds

 private:
  void begin() {
    before_ = progress_of(device_);
    if (repeat) segcal_work_when_due(device_, (*repeat)[late.size()] ? 0 : 1);
  }
  void end(const Id& id) {
    const segcal_progress_t now = progress_of(device_);
    if (!repeat) check_near(id, "slices in a call that feeds", 0, now.slices - before_.slices, 0);
    late.push_back(now.late != before_.late);
  }

  segcal_t* device_;
  segcal_progress_t before_;
};

struct Run {
  std::uint64_t on_the_way, at_the_end;
  std::vector<bool> late;
  segcal_counters_t counters;
};

Run run(const Schedule& schedule, const std::vector<bool>* repeat, const Id& id) {
  Storage storage(0xFF);
  segcal_t* device = create_with_deadlines(&storage, config());
  Feed feed(device);
  feed.repeat = repeat;
  for (std::size_t i = 0; i < thirty().imu.size(); ++i) {
    if (i == kRequest) TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_request_calibration(device));
    feed.sample(i, id.add("sample", i));
    if (i % std::size_t(schedule.every) == 0) segcal_background(device, schedule.slices);
  }
  Run out{feed.hash, 0, feed.late, counters_of(device)};
  segcal_flush(device);
  out.at_the_end = segcal_result_hash(device);
  return out;
}

/// As soon as possible is what the others are compared with. 32 slices a sample are enough in both profiles (a
/// calibration in the time of four segments, half as long here as they are by default), fewer need not be: then the
/// same calls found work undone in a second run without any background, and it comes to the same bits.
void test_schedules() {
  const Run expected = run({1000000, 1}, nullptr, Id().add("slices", "all"));
  TEST_ASSERT_EQUAL_UINT(0, expected.counters.slices_late);
  TEST_ASSERT_EQUAL_UINT(2, expected.counters.calibrations_published);
  const std::vector<bool> never(expected.late.size(), false);
  const Run when_due = run({0, 1}, &never, Id().add("slices", "when due"));
  TEST_ASSERT_TRUE(when_due.on_the_way == expected.on_the_way && when_due.at_the_end == expected.at_the_end);
  int late = 0;
  for (const Schedule& schedule :
       {Schedule{1, 1}, {2, 1}, {4, 1}, {8, 1}, {32, 1}, {1600, 200}, {300, 100}, {1000000, 700}}) {
    const Id id = Id().add("slices", schedule.slices).add("each so many samples", schedule.every);
    const Run now = run(schedule, nullptr, id);
    if (now.counters.slices_late == 0) {
      check_true(id, "another hash on the way", now.on_the_way == expected.on_the_way);
      check_true(id, "another hash at the end", now.at_the_end == expected.at_the_end);
      continue;
    }
    ++late;
    if (schedule.every == 1) check_true(id, "32 slices a sample are enough", schedule.slices < 32);
    const Run again = run({0, 1}, &now.late, id);
    check_true(id, "another hash on the way when repeated", now.on_the_way == again.on_the_way);
    check_true(id, "another hash at the end when repeated", now.at_the_end == again.at_the_end);
    check_near(id, "segments late when repeated", now.counters.segments_late, again.counters.segments_late, 0);
  }
  TEST_ASSERT_GREATER_OR_EQUAL_INT(2, late);  // else the rules for late work were not looked at
}

/// Nothing is ever done: all calls stay bounded, everything is
/// counted, and a background that comes later finds a valid device.
void test_no_background_and_a_late_one() {
  Storage storage(0xFF);
  segcal_t* device = create_with_deadlines(&storage, config());
  Feed feed(device);
  std::size_t i = 0;
  for (; i < 3000; ++i) feed.sample(i, Id().add("sample", i));
  segcal_counters_t c = counters_of(device);
  TEST_ASSERT_EQUAL_UINT(0, c.calibrations);
  TEST_ASSERT_GREATER_OR_EQUAL_UINT(4, c.slices_late);
  if (SEGCAL_START_DELAY_MS ==
      0) {  // the odometry runs; of 7 segments one waits to be scored and the others came too late
    TEST_ASSERT_EQUAL_UINT(c.segments_closed - 1, c.segments_late);
    TEST_ASSERT_EQUAL_INT(SEGCAL_WORK_SCORE, progress_of(device).work);
  } else {
    TEST_ASSERT_EQUAL_UINT(0, c.frames_used);
    TEST_ASSERT_EQUAL_INT(SEGCAL_HEALTH_STARTS_LATE, segcal_get_health(device));
  }
  for (; i < thirty().imu.size(); ++i) {
    feed.sample(i, Id().add("sample", i));
    segcal_background(device, 8);
  }
  segcal_flush(device);
  TEST_ASSERT_EQUAL_UINT(1, counters_of(device).calibrations_published);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_calibrate(device));
  static segcal_result_t r;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(device, &r));
  // The stream's truth is the configuration: five sigmas, as for 26 parameters none is beyond with 0.99998.
  for (int k = 0; k < r.n_parameters; ++k)
    check_near(Id().add("parameter", r.parameter[k].name), "value", r.parameter[k].initial, r.parameter[k].value,
               5 * r.parameter[k].sigma);
}

/// A window of one segment is too short for 20 slices a sample: it
/// stretches, and the result takes effect at the end of a segment.
void test_windows_are_the_users() {
  struct Case {
    int window, slices, missed_least, missed_most;
  };
  for (const Case& now : {Case{1, 1000000, 1, 1}, Case{0, 1000000, 4, 4}, Case{6, 1000000, 6, 6}, Case{1, 20, 2, 10}}) {
    const Id id = Id().add("window", now.window).add("slices", now.slices);
    Storage storage(0xFF);
    segcal_config_t c = config();
    c.calibration_window = now.window;
    segcal_t* device = create_with_deadlines(&storage, c);
    Feed feed(device);
    bool published = false;
    for (std::size_t i = 0; i < thirty().imu.size() && !published; ++i) {
      const std::uint32_t closed = counters_of(device).segments_closed;
      feed.sample(i, id.add("sample", i));
      const segcal_counters_t n = counters_of(device);
      published = n.calibrations_published > 0;
      if (published) check_near(id, "segments that end as it takes effect", 1, n.segments_closed - closed, 0);
      // Scores as soon as possible, the calibration with few slices.
      while (progress_of(device).work == SEGCAL_WORK_SCORE || progress_of(device).work == SEGCAL_WORK_START)
        segcal_background(device, 1);
      segcal_background(device, now.slices);
    }
    check_true(id, "it took effect", published);
    const segcal_counters_t n = counters_of(device);
    check_between(id, "segments missed", now.missed_least, n.segments_missed, now.missed_most);
    check_near(id, "ends at which it was late", n.segments_missed - (now.window == 0 ? 4 : now.window), n.slices_late,
               0);
  }
  Storage storage(0);
  for (const int window : {-1, 1001}) {
    segcal_config_t c = config();
    c.calibration_window = window;
    segcal_t* device;
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CONFIG, segcal_create(&device, &c, storage.data, segcal_storage_bytes()));
  }
}

/// Asked for and flushed in slices: the bits of segcal_flush and segcal_calibrate.
void test_flush_and_calibrate_in_slices() {
  std::uint64_t expected = 0;
  for (const int slices : {0, 1, 50}) {
    const Id id = Id().add("slices", slices);
    Storage storage(0xFF);
    segcal_config_t c = config();
    c.trigger_fraction = -1;
    segcal_t* device = create_with_deadlines(&storage, c);
    for (std::size_t i = 0; i < 2100; ++i) {
      segcal_push_imu(device, &thirty().imu[i]);
      if (i % 20 == 0) push_frame(device, thirty().frames[i / 20], Way::tracks);
      segcal_background(device, 1000000);
    }
    if (slices == 0) {
      segcal_flush(device);
      TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_calibrate(device));
      expected = segcal_result_hash(device);
      continue;
    }
    TEST_ASSERT_EQUAL_INT(1, segcal_flush_slices(device, 0));
    segcal_request_calibration(device);
    int calls = 1;
    std::uint32_t done = 0;
    bool scored = false, calibrated = false;
    for (; segcal_flush_slices(device, slices) == 1; ++calls) {
      const segcal_progress_t p = progress_of(device);
      check_true(id, "the order of work", !(p.work == SEGCAL_WORK_SCORE && calibrated));
      if (p.work == SEGCAL_WORK_CALIBRATION && calibrated)
        check_between(id, "slices of it", done + 1, p.done, done + slices);
      done = p.done;
      scored = scored || p.work == SEGCAL_WORK_SCORE;
      calibrated = calibrated || p.work == SEGCAL_WORK_CALIBRATION;
    }
    check_true(id, "a score and a calibration were seen", scored && calibrated);
    check_between(id, "calls", 500.0 / slices, calls, 1e6);
    check_true(id, "another hash", segcal_result_hash(device) == expected);
    check_near(id, "flushed again", 0, segcal_flush_slices(device, 1), 0);
    const segcal_progress_t p = progress_of(device);
    TEST_ASSERT_EQUAL_INT(SEGCAL_WORK_NONE, p.work);
    TEST_ASSERT_EQUAL_INT(0, p.ends_left);
    check_near(id, "background has nothing left", 0, segcal_background(device, 1), 0);
  }
}

void test_bad_arguments() {
  Storage storage(0);
  segcal_t* device = create_with_deadlines(&storage, config());
  segcal_progress_t p;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_progress(device, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_progress(nullptr, &p));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_request_calibration(nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_work_when_due(nullptr, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_flush_slices(nullptr, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_flush_slices(device, -1));
  TEST_ASSERT_EQUAL_INT(0, segcal_flush_slices(device, 10));
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc - 1, argv + 1);
  UNITY_BEGIN();
  RUN_TEST(test_schedules);
  RUN_TEST(test_no_background_and_a_late_one);
  RUN_TEST(test_windows_are_the_users);
  RUN_TEST(test_flush_and_calibrate_in_slices);
  RUN_TEST(test_bad_arguments);
  return UNITY_END();
}
