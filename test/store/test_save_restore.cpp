// A device across power-off: restored anywhere in memory it goes on with the same bits as
// one that never stopped; what does not fit it is refused by name; power cuts leave the
// old or the new state of a real device; a save beside feeding is whole or not at all.
#include <functional>
#include <memory>

#include "../api/api_fixture.h"
#include "fake_flash.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

const Geometry kFlash = {256, 4096, 0};
FakeFlash new_flash(Geometry g = kFlash) {
  FakeFlash tiny({g.program_bytes, g.erase_bytes, 2});
  const segcal_flash_t port = tiny.port();
  g.blocks = segcal_store_blocks(&port);
  return FakeFlash(g);
}

const SyntheticStream& session(int i) {
  static const SyntheticStream sessions[] = {SyntheticStream(11, 14), SyntheticStream(12, 13), SyntheticStream(13, 12)};
  return sessions[i];
}

void feed(segcal_t* device, int s, Way way = Way::tracks, std::int64_t late_ns = 0) {
  for (std::size_t i = 0; i < session(s).imu.size(); ++i) {
    segcal_push_imu(device, &session(s).imu[i]);
    segcal_background(device, 1000000);
    if (i % 20 != 0) continue;
    SyntheticStream::Frame frame = session(s).frames[i / 20];
    frame.state.t_ns += late_ns;
    if (frame.state.t_ns <= session(s).imu[i].t_ns || way == Way::tracks) push_frame(device, frame, way);
  }
}

segcal_config_t config() {
  segcal_config_t c = SyntheticStream::config();
  c.strategy = SEGCAL_MULTI_SESSION;
  c.keep_segments = 3;
  return c;
}

int finish(segcal_store_t* store) {
  int answer;
  while ((answer = segcal_store_work(store, 5)) == 1) {
  }
  return answer;
}

int save(FakeFlash* flash, segcal_t* device) {
  segcal_store_t store;
  const segcal_flash_t port = flash->port();
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_store_open(&store, &port));
  TEST_ASSERT_GREATER_OR_EQUAL_INT(0, finish(&store));
  const int begun = segcal_save(&store, device);
  return begun == SEGCAL_OK ? finish(&store) : begun;
}

int restore(FakeFlash* flash, segcal_t* device, std::string* difference = nullptr) {
  segcal_store_t store;
  const segcal_flash_t port = flash->port();
  segcal_store_open(&store, &port);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(0, finish(&store));
  const int begun = segcal_restore(&store, device);
  const int answer = begun == SEGCAL_OK ? finish(&store) : begun;
  if (difference) *difference = segcal_store_difference(&store);
  return answer;
}

/// Kinds of devices whose memory differs.
struct Kind {
  const char* name;
  std::function<void(segcal_config_t*)> change;
  Way way;
  std::int64_t late_ns;
};
const Kind kKinds[] = {
    {"multi_session", [](segcal_config_t*) {}, Way::tracks, 0},
    {"single_session", [](segcal_config_t* c) { c->strategy = SEGCAL_SINGLE_SESSION; }, Way::tracks, 0},
    {"set_d", [](segcal_config_t* c) { c->metric = SEGCAL_METRIC_SET_D; }, Way::tracks, 0},
    {"random",
     [](segcal_config_t* c) {
       c->metric = SEGCAL_METRIC_RANDOM;
       c->seed = 77;
     },
     Way::tracks, 0},
    {"adaptive",
     [](segcal_config_t* c) {
       c->least_segment_s = 1.5;
       c->most_segment_s = 3;
     },
     Way::tracks, 0},
    {"odometry", [](segcal_config_t*) {}, Way::keyframes, 0},
    {"time_offset",
     [](segcal_config_t* c) {
       if (SEGCAL_MAX_EFFECT_ESTIMATES >= 1) c->estimate_effects = SEGCAL_EFFECT_TIME_OFFSET;
     },
     Way::tracks, 4000000},
    {"condensing",
     [](segcal_config_t* c) {
       c->keep_segments = 3;
       c->condense = SEGCAL_MAX_EPOCHS > 0 ? 1 : 0;
       c->calibration_window = 1;
     },
     Way::tracks, 0},
    {"watching",
     [](segcal_config_t* c) {
       if (SEGCAL_MAX_EFFECT_COLUMNS >= 3) c->watch_effects = SEGCAL_EFFECT_ROLLING_SHUTTER;
     },
     Way::tracks, 0}};

struct Hashes {
  std::uint64_t begun, ended;  ///< when the second session begins, and when it has ended
  bool operator==(const Hashes& o) const { return begun == o.begun && ended == o.ended; }
};

Hashes second_session(segcal_t* device, const Kind& kind) {
  Hashes h;
  h.begun = segcal_result_hash(device);
  feed(device, 1, kind.way, kind.late_ns);
  segcal_flush(device);
  segcal_calibrate(device);
  h.ended = segcal_result_hash(device);
  return h;
}

enum class Stop { never, before_new_session, after_new_session, saved_and_went_on };

Hashes run(const Kind& kind, Stop stop, int fill, std::size_t offset, segcal_counters_t* counters) {
  segcal_config_t c = config();
  kind.change(&c);
  auto first = std::make_unique<Storage>(0xA5);
  segcal_t* device = create(first.get(), c);
  feed(device, 0, kind.way, kind.late_ns);
  segcal_flush(device);
  segcal_calibrate(device);
  FakeFlash flash = new_flash();
  if (stop == Stop::before_new_session || stop == Stop::saved_and_went_on)
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&flash, device));
  if (stop != Stop::before_new_session) segcal_new_session(device);
  if (stop == Stop::after_new_session) TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&flash, device));
  std::unique_ptr<Storage> second;
  if (stop == Stop::before_new_session || stop == Stop::after_new_session) {
    second = std::make_unique<Storage>(fill, offset);
    first.reset();  // another address, and nothing of the first one is left
    device = create(second.get(), c);
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, restore(&flash, device));
  }
  TEST_ASSERT_EQUAL_INT(0, flash.broken_rules);
  const Hashes h = second_session(device, kind);
  segcal_get_counters(device, counters);
  return h;
}

void test_the_same_bits_as_without_the_stop() {
  for (const Kind& kind : kKinds) {
    segcal_counters_t expected_counters, counters;
    const Hashes expected = run(kind, Stop::never, 0, 0, &expected_counters);
    TEST_ASSERT_TRUE(expected.begun != expected.ended);
    for (const Stop stop : {Stop::saved_and_went_on, Stop::before_new_session, Stop::after_new_session}) {
      const Id id = Id().add("kind", kind.name).add("stop", static_cast<int>(stop));
      if (!selected(id.text())) continue;
      const Hashes h = run(kind, stop, stop == Stop::before_new_session ? 0xFF : 0, 16, &counters);
      check_true(id, "another hash when the session begins", h.begun == expected.begun);
      check_true(id, "another hash at its end", h.ended == expected.ended);
      check_true(id, "other counters",
                 counters.imu_samples == expected_counters.imu_samples &&
                     counters.calibrations == expected_counters.calibrations &&
                     counters.segments_closed == expected_counters.segments_closed &&
                     counters.points_left_out == expected_counters.points_left_out);
    }
  }
}

/// What can be asked about a restored device is what was saved.
void test_results_come_back() {
  Storage one(0), two(0xFF);
  segcal_t *device = create(&one, config()), *again = create(&two, config());
  feed(device, 0);
  segcal_flush(device);
  segcal_calibrate(device);
  FakeFlash flash = new_flash();
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&flash, device));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, restore(&flash, again));
  segcal_result_t a{}, b{};
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(device, &a));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(again, &b));
  TEST_ASSERT_EQUAL_MEMORY(&a, &b, sizeof a);
  static double mean[2][SEGCAL_MAX_PARAMETERS], covariance[2][SEGCAL_MAX_PARAMETERS * SEGCAL_MAX_PARAMETERS];
  const int n = segcal_get_posterior(device, mean[0], covariance[0], SEGCAL_MAX_PARAMETERS * SEGCAL_MAX_PARAMETERS);
  TEST_ASSERT_GREATER_THAN_INT(0, n);
  TEST_ASSERT_EQUAL_INT(
      n, segcal_get_posterior(again, mean[1], covariance[1], SEGCAL_MAX_PARAMETERS * SEGCAL_MAX_PARAMETERS));
  TEST_ASSERT_EQUAL_MEMORY(mean[0], mean[1], n * sizeof(double));
  TEST_ASSERT_EQUAL_MEMORY(covariance[0], covariance[1], n * n * sizeof(double));
  segcal_camera_t cameras[2] = {};
  segcal_get_camera(device, 0, &cameras[0]);
  segcal_get_camera(again, 0, &cameras[1]);
  TEST_ASSERT_EQUAL_MEMORY(&cameras[0], &cameras[1], sizeof cameras[0]);
  static segcal_point_residual_t residuals[2][4000];
  int kept = 0;
  for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
    const int points = segcal_get_point_residuals(device, slot, residuals[0], 4000);
    TEST_ASSERT_EQUAL_INT(points, segcal_get_point_residuals(again, slot, residuals[1], 4000));
    if (points > 0) TEST_ASSERT_EQUAL_MEMORY(residuals[0], residuals[1], points * sizeof residuals[0][0]);
    kept += points > 0 ? 1 : 0;
  }
  TEST_ASSERT_EQUAL_INT(3, kept);
}

/// Each change of the configuration that gives stored numbers
/// another meaning is refused, in words; the device is as created.
void test_another_configuration_is_refused() {
  Storage one(0);
  segcal_t* device = create(&one, config());
  feed(device, 0);
  segcal_flush(device);
  FakeFlash flash = new_flash();
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&flash, device));
  const std::vector<std::uint8_t> cells = flash.cells;
  struct Change {
    const char* name;
    std::function<void(segcal_config_t*)> change;
  };
  const Change changes[] = {{"camera",
                             [](segcal_config_t* c) {
                               c->camera[0].model = SEGCAL_EQUIDISTANT;
                               c->camera[0].distortion[0] = 0;
                             }},
                            {"camera", [](segcal_config_t* c) { c->camera[0].height = 500; }},
                            {"starting calibration", [](segcal_config_t* c) { c->camera[0].intrinsics[1] += 1; }},
                            {"starting calibration", [](segcal_config_t* c) { c->imu.accel_misalignment[2] = 1e-3; }},
                            {"prior_sigma", [](segcal_config_t* c) { c->prior_sigma[3] = 0.5; }},
                            {"imu_rate_hz", [](segcal_config_t* c) { c->imu_rate_hz = 190; }},
                            {"gyro_range", [](segcal_config_t* c) { c->gyro_range = 20; }},
                            {"noise of the IMU", [](segcal_config_t* c) { c->accel_noise_density = 0.01; }},
                            {"pixel_sigma", [](segcal_config_t* c) { c->pixel_sigma = 0.7; }},
                            {"keep_segments", [](segcal_config_t* c) { c->keep_segments = 2; }},
                            {"strategy", [](segcal_config_t* c) { c->strategy = SEGCAL_SINGLE_SESSION; }},
                            {"segment_s", [](segcal_config_t* c) { c->segment_s = 1.5; }},
                            {SEGCAL_PROFILE == SEGCAL_PROFILE_MCU ? "imu_rate_hz or segment_s" : "segment_s",
                             [](segcal_config_t* c) { c->segment_s = 4; }}};
  for (const Change& change : changes) {
    segcal_config_t c = config();
    change.change(&c);
    Storage two(0x5A), fresh(0);
    segcal_t *other = create(&two, c), *created = create(&fresh, c);
    std::string difference;
    const int answer = restore(&flash, other, &difference);
    TEST_ASSERT_EQUAL_INT_MESSAGE(SEGCAL_ERROR_CONFIG, answer, change.name);
    TEST_ASSERT_EQUAL_STRING(change.name, difference.c_str());
    TEST_ASSERT_TRUE(segcal_result_hash(created) == segcal_result_hash(other));
    segcal_result_t result;
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_get_result(other, &result));
    TEST_ASSERT_TRUE(cells == flash.cells);
  }
}

void test_calls_at_the_wrong_time() {
  Storage one(0), two(0);
  segcal_t *device = create(&one, config()), *other = create(&two, config());
  FakeFlash flash = new_flash();
  const segcal_flash_t port = flash.port();
  segcal_store_t store;
  std::memset(&store, 0xFF, sizeof store);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_store_open(nullptr, &port));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_store_work(&store, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_save(&store, device));
  segcal_flash_t bad = port;
  bad.program_bytes = 3;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_store_open(&store, &bad));
  bad = port;
  bad.erase_bytes = 1000;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_store_open(&store, &bad));
  bad = port;
  bad.sync = nullptr;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_store_open(&store, &bad));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_store_open(&store, &port));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_BUSY, segcal_save(&store, device));  // it still looks
  TEST_ASSERT_EQUAL_INT(SEGCAL_EMPTY, finish(&store));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_store_work(&store, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_save(&store, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_restore(&store, device));
  TEST_ASSERT_EQUAL_INT(SEGCAL_EMPTY, finish(&store));
  // An empty store leaves a device that works: the same bits as one that never asked.
  feed(device, 0);
  feed(other, 0);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_restore(&store, device));  // it was fed
  segcal_flush(device);
  segcal_flush(other);
  TEST_ASSERT_TRUE(segcal_result_hash(device) == segcal_result_hash(other));
  segcal_config_t c = config();
  c.joint_filter = 1;
  Storage three(0);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CONFIG, segcal_save(&store, create(&three, c)));
}

/// Power fails at each program and erasure of a device's second save: the restored one is the first state or the
/// second, as `same` has it. `go_on`: what the device does between the two.
template <class GoOn, class Same>
void check_cuts(segcal_t* device, const segcal_config_t& c, GoOn go_on, Same same) {
  Storage two(0), three(0);
  FakeFlash flash = new_flash({128, 4096, 0});
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&flash, device));
  segcal_t* before = create(&three, c);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, restore(&flash, before));
  go_on();
  TEST_ASSERT_TRUE(segcal_result_hash(before) != segcal_result_hash(device));
  int found_old = 0, found_new = 0;
  const auto look = [&](FakeFlash* copy, std::uint64_t cut) {
    segcal_t* restored = create(&two, c);
    const Id id = Id().add("check", "device_cuts").add("cut", cut);
    check_true(id, "nothing restored", restore(copy, restored) == SEGCAL_OK);
    const bool old = segcal_result_hash(restored) == segcal_result_hash(before);
    check_true(id, "neither the old nor the new state",
               old || segcal_result_hash(restored) == segcal_result_hash(device));
    same(restored, old ? before : device, id);
    (old ? found_old : found_new) += 1;
  };
  flash.before = [&](const FakeFlash::Change& change) {
    FakeFlash copy(flash);
    copy.before = nullptr;
    copy.tear(change, flash.operations * 0x9E3779B97F4A7C15ull >> 7);
    look(&copy, flash.operations);
  };
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&flash, device));
  flash.before = nullptr;
  look(&flash, 0);
  std::printf("%d cuts left the old state, %d the new one\n", found_old, found_new);
  TEST_ASSERT_GREATER_THAN_INT(100, found_old);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(1, found_new);
}

void test_power_cuts_of_a_device() {
  Storage one(0);
  segcal_t* device = create(&one, config());
  feed(device, 0);
  segcal_flush(device);
  segcal_calibrate(device);
  segcal_new_session(device);
  check_cuts(
      device, config(),
      [&] {
        feed(device, 2);
        segcal_new_session(device);
      },
      [](segcal_t*, segcal_t*, const Id&) {});
}

/// A save goes on while the device is fed: what is stored is the device as it stood at the call, or, where a segment
/// ended before all was written, what was stored before.
void test_feeding_while_it_saves() {
  for (const int pieces_per_sample : {4, 40}) {
    Storage one(0), two(0);
    segcal_t* device = create(&one, config());
    FakeFlash flash = new_flash();
    feed(device, 0);
    segcal_new_session(device);
    const std::uint64_t at_the_call = segcal_result_hash(device);
    segcal_store_t store;
    const segcal_flash_t port = flash.port();
    segcal_store_open(&store, &port);
    finish(&store);
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_save(&store, device));
    int answer = 1;
    for (std::size_t i = 0; answer == 1; ++i) {
      segcal_push_imu(device, &session(1).imu[i]);
      if (i % 20 == 0) push_frame(device, session(1).frames[i / 20], Way::tracks);
      answer = segcal_store_work(&store, pieces_per_sample);
    }
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, answer);
    segcal_t* restored = create(&two, config());
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, restore(&flash, restored));
    TEST_ASSERT_TRUE(segcal_result_hash(restored) == at_the_call);
    // One piece in thirty samples: the first segment ends before.
    segcal_new_session(device);
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_save(&store, device));
    answer = 1;
    for (std::size_t i = 0; answer == 1 && i < session(2).imu.size(); ++i) {
      segcal_push_imu(device, &session(2).imu[i]);
      if (i % 20 == 0) push_frame(device, session(2).frames[i / 20], Way::tracks);
      if (i % 30 == 0) answer = segcal_store_work(&store, 1);
    }
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_BUSY, answer);
    segcal_t* again = create(&two, config());
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, restore(&flash, again));
    TEST_ASSERT_TRUE(segcal_result_hash(again) == at_the_call);
  }
}

segcal_config_t condensing(bool on) {
  segcal_config_t c = config();
  // From three of mcu's smaller segments the second calibration is none.
  if (SEGCAL_PROFILE == SEGCAL_PROFILE_MCU) c.keep_segments = 5;
  c.condense = on ? 1 : 0;
  c.calibration_window = 1;
  return c;
}

/// Samples [from, until) of 30 s, with the caller's odometry. `lost`: it has lost its way, and no segment fits. Images
/// are `off_px` beside where they should be.
void feed_part(segcal_t* device, std::size_t from, std::size_t until, bool lost, float off_px = 0) {
  for (std::size_t i = from; i < until; ++i) {
    segcal_push_imu(device, &long_stream<30>().imu[i]);
    segcal_background(device, 1000000);
    if (i % 20 != 0) continue;
    SyntheticStream::Frame frame = long_stream<30>().frames[i / 20];
    if (lost) frame.state.p_GI[0] += 0.5 * static_cast<double>(i / 20 % 3);
    for (segcal_point_t& p : frame.points) p.u += off_px;
    push_frame(device, frame, Way::keyframes);
  }
  segcal_flush(device);
}

/// Segments in the epochs, and in the newest.
std::pair<int, int> condensed(segcal_t* device) {
  std::pair<int, int> n = {0, -1};
  segcal_epoch_t e;
  for (int i = 0; segcal_get_epoch(device, i, &e) == SEGCAL_OK; ++i) n = {n.first + e.segments, e.segments};
  return n;
}

/// What sessions said, and the course.
void check_same_history(segcal_t* a, segcal_t* b, const Id& id) {
  segcal_epoch_t one, other;
  int sessions = 0;
  for (; segcal_get_history(a, sessions, &one) == SEGCAL_OK; ++sessions) {
    check_true(id, "a session is missing", segcal_get_history(b, sessions, &other) == SEGCAL_OK);
    check_true(id, "a session says something else", std::memcmp(&one, &other, sizeof one) == 0);
  }
  check_true(id, "sessions too many", segcal_get_history(b, sessions, &other) != SEGCAL_OK);
  check_true(id, "no session", (sessions > 0) == (SEGCAL_MAX_HISTORY > 0));
  segcal_course_t was, is;
  if (segcal_get_course(a, &was) == SEGCAL_OK && segcal_get_course(b, &is) == SEGCAL_OK)
    check_true(id, "another course", std::memcmp(&was, &is, sizeof was) == 0);
}

/// Saved at the end of a session and restored: what comes later has the same bits as in the device that went on.
void check_goes_on(segcal_t* device, const Id& id) {
  Storage again(0x22);
  FakeFlash flash = new_flash();
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&flash, device));
  segcal_t* restored = create(&again, condensing(true));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, restore(&flash, restored));
  segcal_new_session(device);
  check_true(id, "another state", segcal_result_hash(device) == segcal_result_hash(restored));
  for (segcal_t* d : {device, restored}) {
    feed_part(d, 0, 500, true);  // one segment more that does not fit, then good ones
    feed_part(d, 500, 2500, false);
  }
  check_true(id, "another state later", segcal_result_hash(device) == segcal_result_hash(restored));
  check_same_history(device, restored, id);
}

/// Epochs and history are those of the state that was found.
void test_power_cuts_of_a_memory() {
  if (SEGCAL_MAX_EPOCHS == 0) return;
  Storage one(0);
  segcal_t* device = create(&one, condensing(true));
  feed_part(device, 0, 2600, false);
  segcal_calibrate(device);
  segcal_new_session(device);
  feed_part(device, 2600, 3000, false);
  segcal_new_session(device);
  const int segments = condensed(device).first;
  check_cuts(
      device, condensing(true),
      [&] {
        feed_part(device, 3000, 3600, false);
        segcal_new_session(device);
        TEST_ASSERT_GREATER_THAN_INT(segments, condensed(device).first);
      },
      [](segcal_t* restored, segcal_t* was, const Id& id) {
        check_true(id, "other epochs", condensed(restored) == condensed(was));
        check_same_history(restored, was, id);
      });
}

void test_an_open_change_goes_on() {
  if (SEGCAL_MAX_EPOCHS == 0) return;
  Storage storage(0x11), again(0x22);
  segcal_t* device = create(&storage, condensing(true));
  feed_part(device, 0, 2600, false);
  segcal_calibrate(device);
  feed_part(device, 2600, 3500, false, 3);
  segcal_change_t change, restored_change;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_change(device, -1, &change));
  FakeFlash flash = new_flash();
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&flash, device));
  segcal_t* restored = create(&again, condensing(true));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, restore(&flash, restored));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_change(restored, -1, &restored_change));
  TEST_ASSERT_EQUAL_MEMORY(&change, &restored_change, sizeof change);
  segcal_new_session(device);
  for (segcal_t* d : {device, restored}) {
    feed_part(d, 0, 2600, false, 3);
    segcal_calibrate(d);
  }
  TEST_ASSERT_TRUE(segcal_result_hash(device) == segcal_result_hash(restored));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_change(device, 0, &change));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_change(restored, 0, &restored_change));
  TEST_ASSERT_EQUAL_MEMORY(&change, &restored_change, sizeof change);
}

void test_epochs_go_on() {
  if (SEGCAL_MAX_EPOCHS == 0) return;
  {
    Storage storage(0x11);
    segcal_t* device = create(&storage, condensing(true));
    feed_part(device, 0, 3400, false);
    TEST_ASSERT_GREATER_THAN_INT(0, condensed(device).second);
    check_goes_on(device, Id().add("newest", "open"));
  }
  Storage storage(0x11), plain(0x33);
  segcal_t* device = create(&storage, condensing(true));
  feed_part(device, 0, 2400, false);
  segcal_calibrate(device);
  feed_part(device, 2400, 2800, true);
  TEST_ASSERT_EQUAL_INT(0, condensed(device).second);  // begun, and nothing came into it
  FakeFlash flash = new_flash();
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&flash, device));
  check_goes_on(device, Id().add("newest", "empty"));
  // Who restores without condensing does not go on with it.
  segcal_t* other = create(&plain, condensing(false));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, restore(&flash, other));
  const int before = condensed(other).first;
  feed(other, 1, Way::keyframes);
  segcal_flush(other);
  TEST_ASSERT_EQUAL_INT(before, condensed(other).first);
}

}  // namespace

int main(int argc, char** argv) {
  select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_the_same_bits_as_without_the_stop);
  RUN_TEST(test_epochs_go_on);
  RUN_TEST(test_an_open_change_goes_on);
  RUN_TEST(test_results_come_back);
  RUN_TEST(test_another_configuration_is_refused);
  RUN_TEST(test_calls_at_the_wrong_time);
  RUN_TEST(test_power_cuts_of_a_device);
  RUN_TEST(test_power_cuts_of_a_memory);
  RUN_TEST(test_feeding_while_it_saves);
  return UNITY_END();
}
