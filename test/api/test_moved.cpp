// A device whose memory moves: after each slice of its work, or kept as bytes between two sessions, in one block or
// two, it comes to the same bits as one that stays; no address is in its memory; and what is no device is refused.
#include <segcal/blocks.h>

#include <functional>
#include <random>

#include "api_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

struct Kind {
  const char* name;
  std::function<void(segcal_config_t*)> change;
  Way way;
};
const Kind kKinds[] = {
    {"plain", [](segcal_config_t*) {}, Way::tracks},
    {"odometry", [](segcal_config_t*) {}, Way::keyframes},
    {"averaged", [](segcal_config_t* c) { c->segment_s = 4; }, Way::tracks},  // profile mcu: two IMU samples become one
    {"set_d",
     [](segcal_config_t* c) {
       c->metric = SEGCAL_METRIC_SET_D;
       c->keep_segments = 3;
     },
     Way::tracks},
    {"time_offset",
     [](segcal_config_t* c) {
       if (SEGCAL_MAX_EFFECT_ESTIMATES >= 1) c->estimate_effects = SEGCAL_EFFECT_TIME_OFFSET;
     },
     Way::tracks},
    {"g_sensitivity",
     [](segcal_config_t* c) {
       if (SEGCAL_MAX_EFFECT_ESTIMATES >= 9) c->estimate_effects = SEGCAL_EFFECT_GYRO_G_SENSITIVITY;
     },
     Way::tracks},
    {"condensing",
     [](segcal_config_t* c) {
       c->condense = SEGCAL_MAX_EPOCHS > 0 ? 1 : 0;
       c->calibration_window = 1;
     },
     Way::tracks},
    {"watching",
     [](segcal_config_t* c) {
       if (SEGCAL_MAX_EFFECT_COLUMNS >= 3) c->watch_effects = SEGCAL_EFFECT_ROLLING_SHUTTER;
     },
     Way::tracks}};

segcal_config_t config(const Kind& kind) {
  segcal_config_t c = SyntheticStream::config();
  c.outdated_level = 0.1;  // often: comparing is work too
  kind.change(&c);
  return c;
}

/// A device that moves between two pieces of memory, each of one block or of two.
class Mover {
 public:
  Mover(const segcal_config_t& config, bool two_blocks)
      : two_blocks_(two_blocks), place_{{Storage(0x5A), Storage(0xA5)}, {Storage(0x3C, 16), Storage(0xC3)}} {
    const int code =
        two_blocks ? segcal_create_in_blocks(&device, &config, hot(), segcal_hot_bytes(), cold(), segcal_cold_bytes())
                   : segcal_create(&device, &config, hot(), segcal_storage_bytes());
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, code);
    segcal_work_when_due(device, 1);
  }
  /// As bytes, to another place; nothing is left at the old one.
  /// With two blocks: the hot one, the cold one or both, in turns.
  int move() {
    const int which = two_blocks_ ? 1 + moves % 3 : 1;
    ++moves;
    for (int block = 0; block < 2; ++block) {
      if ((which >> block & 1) == 0) continue;
      unsigned char* from = place_[block][at_[block]].data;
      at_[block] ^= 1;
      const std::size_t bytes =
          two_blocks_ ? (block == 0 ? segcal_hot_bytes() : segcal_cold_bytes()) : segcal_storage_bytes();
      std::memcpy(place_[block][at_[block]].data, from, bytes);
      std::memset(from, 0xEE, bytes);
    }
    return segcal_attach(&device, hot(), two_blocks_ ? cold() : nullptr);
  }
  void* hot() { return place_[0][at_[0]].data; }
  void* cold() { return place_[1][at_[1]].data; }
  segcal_t* device = nullptr;
  int moves = 0;

 private:
  bool two_blocks_;
  Storage place_[2][2];
  int at_[2] = {0, 0};
};

/// Feeds a session; `between` is called after each sample and each slice.
void feed(Mover* m, Way way, const std::function<void()>& between) {
  const SyntheticStream& s = long_stream<14>();
  for (std::size_t i = 0; i < s.imu.size(); ++i) {
    segcal_push_imu(m->device, &s.imu[i]);
    if (i % 20 == 0) push_frame(m->device, s.frames[i / 20], way);
    between();
    for (int slice = 0; slice < 24 && segcal_background(m->device, 1) == 1; ++slice) between();
  }
  while (segcal_flush_slices(m->device, 1) == 1) between();
  segcal_request_calibration(m->device);
  while (segcal_flush_slices(m->device, 1) == 1) between();
}

std::uint64_t hash_where_it_stays(const Kind& kind) {
  Mover m(config(kind), false);
  feed(&m, kind.way, [] {});
  segcal_result_t result;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(m.device, &result));
  TEST_ASSERT_GREATER_THAN_INT(1, result.segments);
  return segcal_result_hash(m.device);
}

/// A prime, so that all kinds of work are met over a session; each slice would take minutes with the larger profiles.
constexpr int kEvery = SEGCAL_PROFILE == SEGCAL_PROFILE_MCU ? 1 : 7;

void test_one_block_at_any_moment() {
  for (const Kind& kind : kKinds) {
    const Id id = Id().add("kind", kind.name);
    if (!selected(id.text())) continue;
    Mover m(config(kind), false);
    int calls = 0;
    feed(&m, kind.way, [&] {
      if (++calls % kEvery == 0) TEST_ASSERT_EQUAL_INT(SEGCAL_OK, m.move());
    });
    check_true(id, ("moved " + std::to_string(m.moves) + " times").c_str(), m.moves > 3000);
    check_true(id, "the same bits", segcal_result_hash(m.device) == hash_where_it_stays(kind));
  }
}

void test_two_blocks_each_for_itself() {
  for (const Kind& kind : kKinds) {
    const Id id = Id().add("kind", kind.name);
    if (!selected(id.text())) continue;
    Mover m(config(kind), true);
    segcal_progress_t progress;
    feed(&m, kind.way, [&] {
      segcal_progress(m.device, &progress);
      if (progress.work == SEGCAL_WORK_NONE) TEST_ASSERT_EQUAL_INT(SEGCAL_OK, m.move());
    });
    check_true(id, ("moved " + std::to_string(m.moves) + " times").c_str(), m.moves > 300);
    check_true(id, "the same bits", segcal_result_hash(m.device) == hash_where_it_stays(kind));
  }
}

/// By different distances while work is pending: refused, and nothing is lost where they were.
void test_apart_while_work_is_pending() {
  Mover m(config(kKinds[0]), true);
  segcal_progress_t progress;
  int refused = 0;
  feed(&m, Way::tracks, [&] {
    segcal_progress(m.device, &progress);
    if (progress.work == SEGCAL_WORK_NONE || ++refused % 50 != 0) return;
    Storage elsewhere(0x77);
    std::memcpy(elsewhere.data, m.hot(), segcal_hot_bytes());
    segcal_t* moved = m.device;
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_BUSY, segcal_attach(&moved, elsewhere.data, m.cold()));
    TEST_ASSERT_NULL(moved);
  });
  TEST_ASSERT_GREATER_THAN_INT(1000, refused);
  TEST_ASSERT_TRUE(segcal_result_hash(m.device) == hash_where_it_stays(kKinds[0]));
}

/// No word of its memory is an address in it.
void test_no_address_inside() {
  for (const Kind& kind : kKinds) {
    const Id id = Id().add("kind", kind.name);
    if (!selected(id.text())) continue;
    Mover m(config(kind), false);
    int calls = 0, found = 0;
    const auto begin = reinterpret_cast<std::uintptr_t>(m.hot()), bytes = segcal_storage_bytes();
    feed(&m, kind.way, [&] {
      if (++calls % 101 != 0) return;
      for (std::uintptr_t at = 0; at + sizeof at <= bytes; at += sizeof at) {
        std::uintptr_t word;
        std::memcpy(&word, static_cast<unsigned char*>(m.hot()) + at, sizeof word);
        found += word - begin < bytes ? 1 : 0;
      }
    });
    check_true(id, ("words that are addresses: " + std::to_string(found)).c_str(), found == 0);
  }
}

void test_what_is_no_device_is_refused() {
  Mover m(config(kKinds[0]), false), apart(config(kKinds[0]), true);
  segcal_t* device = m.device;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_attach(nullptr, m.hot(), nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_attach(&device, nullptr, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_ALIGNMENT, segcal_attach(&device, static_cast<char*>(m.hot()) + 4, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_ALIGNMENT,
                        segcal_attach(&device, apart.hot(), static_cast<char*>(apart.cold()) + 4));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_attach(&device, apart.hot(), nullptr));
  Mover other(config(kKinds[0]), true);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_attach(&device, apart.hot(), other.cold()));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_attach(&device, apart.cold(), apart.hot()));
  TEST_ASSERT_EQUAL_INT(
      SEGCAL_ERROR_STATE,
      segcal_attach(&device, m.hot(), static_cast<char*>(m.hot()) + (SEGCAL_HOT_BYTES + 15) / 16 * 16));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_attach(&device, apart.hot(), apart.cold()));
  Storage random(0);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_attach(&device, apart.hot(), random.data));
  std::mt19937 draw(5);
  for (std::size_t i = 0; i < segcal_storage_bytes(); ++i) random.data[i] = static_cast<unsigned char>(draw());
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_attach(&device, random.data, nullptr));
  TEST_ASSERT_NULL(device);
  const segcal_config_t c = config(kKinds[0]);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_create_in_blocks(&device, &c, m.hot(), segcal_hot_bytes() - 1,
                                                                   apart.cold(), segcal_cold_bytes()));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_create_in_blocks(&device, &c, m.hot(), segcal_hot_bytes(),
                                                                   apart.cold(), segcal_cold_bytes() - 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_create_in_blocks(&device, &c, random.data, segcal_hot_bytes(),
                                                                   random.data, segcal_cold_bytes()));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE,
                        segcal_create_in_blocks(&device, &c, random.data, segcal_hot_bytes(),
                                                random.data + segcal_hot_bytes() / 32 * 16, segcal_cold_bytes()));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_attach(&device, m.hot(), nullptr));
}

void test_the_ledger_is_exact_to_a_few_per_cent() {
  TEST_ASSERT_TRUE(segcal_hot_bytes() <= SEGCAL_HOT_BYTES && SEGCAL_HOT_BYTES < segcal_hot_bytes() * 17 / 16);
  TEST_ASSERT_TRUE(segcal_cold_bytes() <= SEGCAL_COLD_BYTES && SEGCAL_COLD_BYTES < segcal_cold_bytes() * 17 / 16);
}

}  // namespace

int main(int argc, char** argv) {
  select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_one_block_at_any_moment);
  RUN_TEST(test_two_blocks_each_for_itself);
  RUN_TEST(test_apart_while_work_is_pending);
  RUN_TEST(test_no_address_inside);
  RUN_TEST(test_what_is_no_device_is_refused);
  RUN_TEST(test_the_ledger_is_exact_to_a_few_per_cent);
  return UNITY_END();
}
